//! Cores that remember.

use crate::draw::Draw;
use crate::effect::{Effect, named, on_sensor};
use crate::finer::jiles::Jiles;
use crate::finer::plays::Plays;
use crate::scene::{Campaign, Run};

/// Quarters of a step that the drive has gone on before a recording whose past counts.
pub const PAST: usize = 400;

/// What a core that follows the field along a sensor gives at each row, the way between the rows in quarters
/// of a step, with so many quarters before the first row.
pub fn followed(
    campaign: &Campaign,
    run: &Run,
    sensor: usize,
    past: usize,
    mut go: impl FnMut(f64) -> f64,
) -> Vec<f64> {
    let quarter = 0.25 * run.step_s();
    let at = |t: f64| run.along(&campaign.bench, sensor, t);
    let first = run.times.first().copied().unwrap_or(0.0);
    (0..past).rev().for_each(|k| {
        go(at(first - quarter * k as f64));
    });
    run.times
        .iter()
        .map(|t| {
            (1..4).rev().for_each(|k| {
                go(at(t - quarter * f64::from(k)));
            });
            go(at(*t))
        })
        .collect()
}

/// Domain walls that are pinned (Jiles and Atherton), whose past is the drive before the recording.
pub fn pinned_walls(_: &Campaign, draw: &mut Draw) -> Effect {
    let sensor = draw.below(3);
    let (shape, pinning) = (draw.octaves(25_000.0, 60_000.0), draw.octaves(700.0, 4000.0));
    let reversible = draw.between(0.1, 0.3);
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let mut core = Jiles::new(shape, pinning, reversible);
        let lag = followed(campaign, run, sensor, PAST, |field| core.lag(field));
        lag.into_iter().map(|lag| 20.0 * size * lag).collect()
    });
    let accepted = vec![named("hysteresis", sensor)];
    Effect::new("Jiles and Atherton's model of pinned walls", accepted, act).in_sensor(sensor)
}

/// Five play operators whose weights fall with their half-widths.
pub fn plays(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, width) = (draw.below(3), draw.octaves(300.0, 1500.0));
    let operators: [(f64, f64); 5] =
        std::array::from_fn(|k| (width * (k + 1) as f64, (-(k as f64) / 2.0).exp() / width));
    let sum: f64 = operators.iter().map(|(_, weight)| weight).sum();
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let mut core = Plays::new(operators);
        let lag = followed(campaign, run, sensor, PAST, |field| core.go(field) - sum * field);
        lag.into_iter().map(|lag| 0.2 * size * lag).collect()
    });
    Effect::new("sum of five play operators", vec![named("hysteresis", sensor)], act).in_sensor(sensor)
}

/// Least and largest threshold of permanent magnetisation, over the largest field along the sensor.
const THRESHOLD: [f64; 2] = [0.55, 0.8];

/// Parts near the core that large fields magnetise, their thresholds log-normal; without magnetisation at the
/// beginning of each recording.
pub fn perming(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, share, spread) =
        (draw.below(3), draw.between(THRESHOLD[0], THRESHOLD[1]), draw.between(0.03, 0.08));
    let threshold = share * largest_field(campaign, sensor);
    let ppm = 20.0 * draw.sign();
    let operators: [(f64, f64); 11] = std::array::from_fn(|k| {
        let position = k as f64 / 2.0 - 2.5;
        (threshold * (spread * position).exp(), (-0.5 * position * position).exp())
    });
    let sum: f64 = operators.iter().map(|(_, weight)| weight).sum();
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let mut parts = Plays::new(operators);
        let remanent = followed(campaign, run, sensor, 0, |field| parts.go(field) / sum);
        remanent.into_iter().map(|nt| 1e-6 * size * ppm * nt).collect()
    });
    Effect::new(
        "parts that large fields magnetise, thresholds log-normal",
        vec![named("perming", sensor)],
        act,
    )
    .in_sensor(sensor)
    .with(move |size| vec![("remanence_ppm", size * ppm), ("threshold_nt", threshold)])
}

/// Largest field along a sensor in the campaign, nT.
fn largest_field(campaign: &Campaign, sensor: usize) -> f64 {
    let of = |run: &Run| {
        let along = |t: &f64| run.along(&campaign.bench, sensor, *t).abs();
        run.times.iter().map(along).fold(0.0, f64::max)
    };
    campaign.runs.iter().map(of).fold(0.0, f64::max)
}
