//! What ages: its course over a campaign is nearly straight, since the instrument is older than the campaign is long.

use super::electronics::span;
use crate::draw::Draw;
use crate::effect::{Effect, named, on_sensor};
use crate::finer::relaxation;
use crate::scene::Campaign;

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

/// Stretched exponential of something five to twenty campaigns old, its time constant three times as long as that.
pub fn stretched(span: f64, draw: &mut Draw) -> Course {
    let (age, exponent) = (span * draw.octaves(5.0, 20.0), draw.between(0.4, 0.7));
    to_one(span, move |t| relaxation::stretched(t, age, 3.0 * age, exponent))
}

/// Root of the time of service, two to ten campaigns.
pub fn root(span: f64, draw: &mut Draw) -> Course {
    let age = span * draw.octaves(2.0, 10.0);
    to_one(span, move |t| relaxation::root(t, age))
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
