//! Effects whose form is not quite what any formula has: the size of a contribution wanders with time or with
//! the field.

use std::sync::Arc;

use crate::draw::Draw;
use crate::effect::Effect;
use crate::scene::{Campaign, Run, SceneKind};
use crate::signal::wandering;

/// Largest rms of a form error, relative.
const MOST: f64 = 0.2;

/// Moments, codes and single events: none of them has a gain that could err.
const WITHOUT: [&str; 9] = [
    "clipping",
    "dropout",
    "clock_offset",
    "clock_rate",
    "quantisation",
    "differential_nonlinearity",
    "saturation",
    "reading_step",
    "spike",
];

/// The effect with its contribution c made c (1 + ε w), and ε, uniform between 0 and [`MOST`].
///
/// w has mean 0 and rms 1 over the campaign: three sines of random periods between a third and three times
/// what time, or the field along the sensor, goes through. What is in the field, or read while the coils are
/// held, wanders with time alone.
pub fn inexact(name: &str, effect: Effect, campaign: &Campaign, draw: &mut Draw) -> (Effect, f64) {
    if WITHOUT.contains(&name) {
        return (effect, 0.0);
    }
    let size = draw.between(0.0, MOST);
    let by_field = draw.between(0.0, 1.0) < 0.5 && campaign.kind != SceneKind::Held;
    let sensor = effect.sensors.first().copied().filter(|_| by_field);
    let along = |run: &Run, t: f64| sensor.map_or(t, |sensor| run.along(&campaign.bench, sensor, t));
    let mut course: Vec<Vec<f64>> = campaign
        .runs
        .iter()
        .map(|run| run.times.iter().map(|t| along(run, *t)).collect::<Vec<f64>>())
        .collect();
    let all = || course.iter().flatten().copied();
    let gone = all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min);
    let wander = wandering(draw, 1.0, [gone / 3.0, 3.0 * gone], 3);
    course.iter_mut().flatten().for_each(|x| *x = wander(*x));
    let count = course.iter().flatten().count().max(1) as f64;
    let mean = course.iter().flatten().sum::<f64>() / count;
    course.iter_mut().flatten().for_each(|w| *w -= mean);
    let rms = (course.iter().flatten().map(|w| w * w).sum::<f64>() / count).sqrt();
    course.iter_mut().flatten().for_each(|w| *w = 1.0 + size * *w / rms);
    let exact = effect.act.clone();
    let act = Arc::new(move |campaign: &Campaign, plain: &_, size: f64| {
        let mut added = exact(campaign, plain, size);
        for (added, gain) in added.iter_mut().zip(&course) {
            for column in added {
                column.iter_mut().zip(gain).for_each(|(value, gain)| *value *= gain);
            }
        }
        added
    });
    (Effect { act, ..effect }, size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinds;
    use crate::scenes::{self, Length};

    /// The contribution departs from its formula by ε of its own size, on the average over courses.
    #[test]
    fn a_form_error_has_the_stated_size() {
        let mut draw = Draw::new("form", 1);
        let campaign = scenes::campaign(SceneKind::Coils, Length::Medium, true, None, &mut draw);
        let plain = campaign.plain();
        let kind = kinds::ALL.into_iter().find(|kind| kind.name == "offset_temperature").expect("a kind");
        let exact = (kind.make)(&campaign, &mut draw);
        let of = |effect: &Effect| (effect.act)(&campaign, &plain, 1.0).into_iter().flatten().flatten();
        let (mut squares, mut stated) = (0.0, 0.0);
        for _ in 0..200 {
            let (erring, size) = inexact(kind.name, exact.clone(), &campaign, &mut draw);
            let off: f64 = of(&erring).zip(of(&exact)).map(|(a, b)| (a - b).powi(2)).sum();
            squares += off / of(&exact).map(|b| b * b).sum::<f64>();
            stated += size * size;
            assert!((0.0..=MOST).contains(&size));
        }
        assert!((squares / stated - 1.0).abs() < 0.25, "{squares} for {stated}");
        assert_eq!(inexact("spike", exact, &campaign, &mut draw).1, 0.0);
    }
}
