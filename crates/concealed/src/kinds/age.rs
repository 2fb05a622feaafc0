//! What ages: its course over a campaign is nearly straight, since the instrument is older than the campaign
//! is long.

use std::sync::Arc;

use super::electronics::span;
use crate::draw::Draw;
use crate::effect::{Act, Effect, named, on_sensor};
use crate::finer::relaxation;
use crate::scene::{Campaign, Readings, Run};

/// A day, s.
pub const DAY_S: f64 = 86_400.0;

/// A course over a campaign of a span, from 0 at its beginning to 1 at its end.
pub type Course = Box<dyn Fn(f64) -> f64 + Send + Sync>;

fn to_one(span: f64, course: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Course {
    let end = course(span);
    Box::new(move |t| course(t) / end)
}

/// Relaxation over barriers of all heights, of something five to twenty campaigns old.
pub fn logarithm(span: f64, draw: &mut Draw) -> Course {
    let age = span * draw.octaves(5.0, 20.0);
    to_one(span, move |t| relaxation::logarithmic(t, age))
}

/// Stretched exponential of something five to twenty campaigns old, its time constant three times as long as
/// that.
pub fn stretched(span: f64, draw: &mut Draw) -> Course {
    let (age, exponent) = (span * draw.octaves(5.0, 20.0), draw.between(0.4, 0.7));
    to_one(span, move |t| relaxation::stretched(t, age, 3.0 * age, exponent))
}

/// Root of the time of service, two to ten campaigns.
pub fn root(span: f64, draw: &mut Draw) -> Course {
    let age = span * draw.octaves(2.0, 10.0);
    to_one(span, move |t| relaxation::root(t, age))
}

/// Two exponentials of something about as old as the campaign is long, the quicker one nearly over.
pub fn two(span: f64, draw: &mut Draw) -> Course {
    let age = span * draw.octaves(1.0, 3.0);
    let (slow, quick) = (span * draw.octaves(5.0, 15.0), span * draw.octaves(0.6, 1.2));
    to_one(span, move |t| relaxation::two(t, age, [(0.85, slow), (0.15, quick)]))
}

/// An offset that moves by a nT in the campaign.
pub fn offset(
    campaign: &Campaign,
    draw: &mut Draw,
    physics: &'static str,
    law: fn(f64, &mut Draw) -> Course,
) -> Effect {
    let (sensor, size, span) = (draw.below(3), draw.sign(), span(campaign));
    let course = law(span, draw);
    let act = on_sensor(sensor, move |_, run, _, times| {
        run.times.iter().map(|t| times * size * course(*t)).collect()
    });
    Effect::new(physics, vec![named("ageing", sensor)], act)
        .in_sensor(sensor)
        .with(move |times| vec![("rate_nt_per_day", times * size * DAY_S / span)])
}

/// A sensitivity that moves by 20 ppm in the campaign.
pub fn sensitivity(
    campaign: &Campaign,
    draw: &mut Draw,
    physics: &'static str,
    law: fn(f64, &mut Draw) -> Course,
) -> Effect {
    let (sensor, ppm, span) = (draw.below(3), 20.0 * draw.sign(), span(campaign));
    let course = law(span, draw);
    let act = on_sensor(sensor, move |_, run, plain, size| {
        let grown = |(t, reading): (&f64, &f64)| 1e-6 * size * ppm * course(*t) * reading;
        run.times.iter().zip(plain).map(grown).collect()
    });
    Effect::new(physics, vec![named("sensitivity_ageing", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| vec![("rate_ppm_per_day", size * ppm * DAY_S / span)])
}

/// Of half the energy of an electron volt over Boltzmann's constant, K.
const ACTIVATION_K: f64 = 5800.0;

/// A feedback coil whose glue ages the faster the warmer it is.
pub fn warm_glue(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, ppm, span) = (draw.below(3), 20.0 * draw.sign(), span(campaign));
    let act: Act = Arc::new(move |campaign: &Campaign, plain: &Readings, size: f64| {
        // From one run to the next it ages at the rate of the latter's beginning.
        let (mut aged, mut at) = (0.0, 0.0);
        let mut of_run = |run: &Run| -> Vec<f64> {
            let rate =
                |t: f64| relaxation::hastened(run.temperatures[0](t), campaign.reference_c[0], ACTIVATION_K);
            let next = |&time: &f64| {
                aged += 0.5 * (rate(at) + rate(time)) * (time - at);
                at = time;
                aged / span
            };
            run.times.iter().map(next).collect()
        };
        let one = |(run, plain): (&Run, &[Vec<f64>; 3])| {
            let mut added = [0; 3].map(|_| vec![0.0; run.times.len()]);
            let grown = |(aged, reading): (f64, &f64)| 1e-6 * size * ppm * aged * reading;
            added[sensor] = of_run(run).into_iter().zip(&plain[sensor]).map(grown).collect();
            added
        };
        campaign.runs.iter().zip(plain).map(one).collect()
    });
    Effect::new("glue that ages the faster the warmer it is", vec![named("sensitivity_ageing", sensor)], act)
        .in_sensor(sensor)
}
