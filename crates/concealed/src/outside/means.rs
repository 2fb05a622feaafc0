//! What the physics outside is made with.

use nalgebra::Vector3;

use crate::draw::Draw;
use crate::effect::{Act, Effect, on_sensor};
use crate::scene::{Campaign, Run};

/// In one sensor, drawn at random.
pub fn in_one(
    physics: &'static str,
    draw: &mut Draw,
    of: impl Fn(&Campaign, &Run, usize, f64) -> Vec<f64> + Send + Sync + 'static,
) -> Effect {
    let sensor = draw.below(3);
    let act: Act = on_sensor(sensor, move |campaign, run, _, size| of(campaign, run, sensor, size));
    Effect::new(physics, Vec::new(), act).in_sensor(sensor)
}

/// The end of the campaign, s.
pub fn span(campaign: &Campaign) -> f64 {
    campaign.runs.last().and_then(|run| run.times.last()).copied().unwrap_or(1.0)
}

/// A direction at random.
pub fn direction(draw: &mut Draw) -> Vector3<f64> {
    Vector3::from_fn(|_, _| draw.normal()).normalize()
}

/// Mean over all rows of a campaign.
pub fn mean(campaign: &Campaign, of: impl Fn(&Run, f64) -> f64) -> f64 {
    let all = || campaign.runs.iter().flat_map(|run| run.times.iter().map(|t| of(run, *t)));
    all().sum::<f64>() / all().count().max(1) as f64
}

/// Moments at random in every run, one for so many readings.
pub fn moments(campaign: &Campaign, readings: usize, draw: &mut Draw) -> Vec<f64> {
    let mut all = Vec::new();
    for run in &campaign.runs {
        let length = run.times.len() as f64 * run.step_s();
        let begin = run.times.first().copied().unwrap_or(0.0);
        (0..run.times.len() / readings).for_each(|_| all.push(begin + length * draw.between(0.0, 1.0)));
    }
    all
}

/// Derivative by time over a second.
pub fn rate(of: impl Fn(f64) -> f64, t: f64) -> f64 {
    of(t + 0.5) - of(t - 0.5)
}
