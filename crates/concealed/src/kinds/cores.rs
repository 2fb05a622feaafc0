//! Cores: further laws of their loops and of their bends.

use super::loops::{PAST, followed};
use super::sensor::of_fields;
use crate::draw::Draw;
use crate::effect::{Effect, named, on_sensor};
use crate::finer::bouc::Bouc;
use crate::finer::rayleigh::Rayleigh;
use crate::scene::Campaign;

/// A core that is unloaded more slowly than it is loaded (Bouc and Wen), whose past is the drive before the
/// recording.
pub fn loaded_and_unloaded(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, width, share) = (draw.below(3), draw.octaves(700.0, 4000.0), draw.between(0.2, 0.4));
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let mut core = Bouc::new(width, share);
        let held = followed(campaign, run, sensor, PAST, |field| core.go(field));
        held.into_iter().map(|z| -size * z).collect()
    });
    Effect::new("Bouc and Wen's model, unloading unlike loading", vec![named("hysteresis", sensor)], act)
        .in_sensor(sensor)
}

/// Field in which Rayleigh's loops are drawn, nT.
const WEAK_NT: f64 = 30_000.0;

/// A core that is far from saturation: loops of parabolas (Rayleigh).
pub fn weak_fields(_: &Campaign, draw: &mut Draw) -> Effect {
    let sensor = draw.below(3);
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let mut core = Rayleigh::default();
        let loops = followed(campaign, run, sensor, PAST, |field| core.go(field / WEAK_NT));
        loops.into_iter().map(|m| 5.0 * size * m).collect()
    });
    Effect::new("Rayleigh's law of weak fields", vec![named("hysteresis", sensor)], act).in_sensor(sensor)
}

/// What a rectifier with the law of a diode makes even: ln cosh, a parabola that straightens.
pub fn unlike_halves(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, size, width) = (draw.below(3), draw.sign(), draw.between(0.8, 1.5));
    let act = of_fields(sensor, move |x, _, _| size * 2.0 * width * width * (x / width).cosh().ln());
    Effect::new("halves of a rectifier that are unlike", vec![named("quadratic_nonlinearity", sensor)], act)
        .in_sensor(sensor)
}

/// A loop whose gain falls as the core's curve does towards its ends: an arctangent.
pub fn arctangent(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, size, width) = (draw.below(3), draw.sign(), draw.between(2.0, 4.0));
    let act = of_fields(sensor, move |x, _, _| size * 3.0 * width.powi(3) * (x / width - (x / width).atan()));
    Effect::new("core with the curve of an arctangent", vec![named("cubic_nonlinearity", sensor)], act)
        .in_sensor(sensor)
}

/// The field along a hard axis across the sensor, over a scale.
fn hard_axis(draw: &mut Draw) -> impl Fn(f64, f64) -> f64 + Send + Sync + 'static {
    let (sin, cos) = draw.between(0.0, std::f64::consts::TAU).sin_cos();
    move |u, v| cos * u + sin * v
}

/// A core whose magnetisation a field across turns towards its hard axis: √(1 + w²) − 1.
pub fn turned_core(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, size, scale) = (draw.below(3), 4.0 * draw.sign(), draw.between(1.5, 3.0));
    let hard = hard_axis(draw);
    let act = of_fields(sensor, move |_, u, v| {
        let w = hard(u, v) / scale;
        size * 2.0 * scale * scale * ((1.0 + w * w).sqrt() - 1.0)
    });
    Effect::new("core that a field across turns to its hard axis", vec![named("cross_field", sensor)], act)
        .in_sensor(sensor)
}

/// A core whose easy axis is tilted: a field along the hard axis shifts its permeability, up to an end.
pub fn tilted_core(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, size, scale) = (draw.below(3), 4.0 * draw.sign(), draw.between(1.2, 2.5));
    let hard = hard_axis(draw);
    let act = of_fields(sensor, move |own, u, v| size * own * scale * (hard(u, v) / scale).tanh());
    let accepted = vec![named("cross_field_sensitivity", sensor)];
    Effect::new("core with a tilted easy axis", accepted, act).in_sensor(sensor)
}
