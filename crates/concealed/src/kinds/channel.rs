//! One channel between sensor and logger.

use super::electronics::span;
use crate::draw::Draw;
use crate::effect::{Effect, named, on_sensor};
use crate::finer::{average, bandgap, clip, convection, poles};
use crate::scene::Campaign;

/// A channel that is handed on late, each time a little unlike.
pub fn uneven_delay(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, seed) = (draw.below(3), draw.below(1 << 20) as u64);
    let delay = move |size: f64| 2e-3 * size;
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let mut ticks = Draw::new(&format!("delay/{}", run.id), seed);
        let at = |t: f64| run.along(&campaign.bench, sensor, t);
        run.times.iter().map(|t| at(t - delay(size) * (1.0 + 0.02 * ticks.normal())) - at(*t)).collect()
    });
    Effect::new("delay that jitters by a fiftieth", vec![named("delay", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| vec![("delay_s", delay(size))])
}

/// A converter that takes the mean over a while: late by half of it, and its gain between that of a delay and
/// that of a lag.
pub fn moving_average(_: &Campaign, draw: &mut Draw) -> Effect {
    let sensor = draw.below(3);
    let delay = move |size: f64| 2e-3 * size;
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let at = |t: f64| run.along(&campaign.bench, sensor, t);
        run.times.iter().map(|t| average::mean_before(at, *t, 2.0 * delay(size)) - at(*t)).collect()
    });
    let accepted = vec![named("delay", sensor), named("loop_bandwidth", sensor)];
    Effect::new("converter that takes the mean over a while", accepted, act)
        .in_sensor(sensor)
        .with(move |size| vec![("delay_s", delay(size)), ("lag_s", delay(size))])
}

/// A loop with three equal poles.
pub fn three_poles(_: &Campaign, draw: &mut Draw) -> Effect {
    let sensor = draw.below(3);
    let lag = move |size: f64| 2e-3 * size;
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let at = |t: f64| run.along(&campaign.bench, sensor, t);
        run.times.iter().map(|t| poles::three(at, *t, lag(size) / 3.0) - at(*t)).collect()
    });
    let accepted = vec![named("loop_bandwidth", sensor), named("delay", sensor)];
    Effect::new("loop with three equal poles", accepted, act)
        .in_sensor(sensor)
        .with(move |size| vec![("lag_s", lag(size)), ("delay_s", lag(size))])
}

/// An amplifier that ends below the largest fields, its edge rounded over some nT.
pub fn clipping(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, width) = (draw.below(3), draw.between(1.0, 3.0));
    let plain = campaign.plain();
    let largest = plain.iter().flat_map(|run| &run[sensor]).fold(0.0, |most: f64, m| most.max(m.abs()));
    // What is cut off grows faster than the depth of the cut.
    let level = move |size: f64| (largest + width - 50.0 * size.sqrt()).max(0.3 * largest);
    let act = on_sensor(sensor, move |_, _, plain, size| {
        plain.iter().map(|reading| clip::clipped(*reading, level(size), width) - reading).collect()
    });
    Effect::new("amplifier with a rounded end", vec![named("clipping", sensor)], act)
        .in_sensor(sensor)
        .of_codes()
        .with(move |size| vec![("level_nt", level(size))])
}

/// A connection that fails for a while: the logger holds the last value, which leaks away slowly, and the row
/// in which the connection comes back is the mean of both.
pub fn dropout(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, leak) = (draw.below(3), draw.sign() * draw.between(0.002, 0.008));
    let longest = campaign.runs[0].times.len() as f64;
    let first = (longest * draw.between(0.2, 0.4)) as usize;
    let act = on_sensor(sensor, move |_, _, plain, size| {
        let rows = (20.0 * size.powf(0.7)).min(0.5 * longest);
        let held = |row: usize| {
            let since = row as f64 - first as f64;
            let share = if since < 0.0 { 0.0 } else { (rows - since).clamp(0.0, 1.0) };
            share * (plain[first - 1] + leak * since - plain[row])
        };
        (0..plain.len()).map(held).collect()
    });
    Effect::new("held value that leaks away slowly", vec![named("dropout", sensor)], act)
        .in_sensor(sensor)
        .of_codes()
}

/// A board and the box about it, each with a time constant.
pub fn board_and_box(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, size) = (draw.below(3), draw.sign());
    let tau = span(campaign) * draw.octaves(0.1, 0.25);
    let (quick, share) = (tau * draw.between(0.15, 0.3), draw.between(0.2, 0.4));
    let act = on_sensor(sensor, move |_, run, _, times| {
        let left = |t: &f64| (1.0 - share) * (-t / tau).exp() + share * (-t / quick).exp();
        run.times.iter().map(|t| times * size * left(t)).collect()
    });
    Effect::new("board and box that warm after switch-on", vec![named("warm_up", sensor)], act)
        .in_sensor(sensor)
}

/// A reference of a semiconductor's band gap, level far from the temperatures of the campaign.
pub fn bandgap_reference(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let reference_c = campaign.reference_c[1];
    let (sensor, level_c) = (draw.below(3), reference_c + draw.sign() * draw.between(20.0, 45.0));
    let act = on_sensor(sensor, move |_, run, plain, size| {
        let at_reference = bandgap::departure(reference_c, level_c);
        let gain = |t: f64| bandgap::departure(run.temperatures[1](t), level_c) - at_reference;
        run.times.iter().zip(plain).map(|(t, reading)| size * gain(*t) * reading).collect()
    });
    let accepted = vec![named("sensitivity_electronics_temperature", sensor)];
    Effect::new("reference of a semiconductor's band gap", accepted, act).in_sensor(sensor).with(
        move |size| {
            vec![
                ("coefficient_ppm_per_k", 1e6 * size * bandgap::slope(reference_c, level_c)),
                ("curvature_ppm_per_k2", 1e6 * size * bandgap::curvature(reference_c)),
            ]
        },
    )
}

/// Resistors of a divider whose materials part with the temperature of the electronics: (1 + a T) / (1 + b
/// T).
pub fn divider(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, upper, lower) = (draw.below(3), 40.0 * draw.sign(), draw.between(-15.0, 15.0));
    let act = on_sensor(sensor, move |campaign, run, plain, size| {
        let gain = |t: f64| {
            let warm = 1e-6 * (run.temperatures[1](t) - campaign.reference_c[1]);
            (1.0 + size * upper * warm) / (1.0 + size * lower * warm) - 1.0
        };
        run.times.iter().zip(plain).map(|(t, reading)| gain(*t) * reading).collect()
    });
    let accepted = vec![named("sensitivity_electronics_temperature", sensor)];
    Effect::new("divider of unlike resistors", accepted, act)
        .in_sensor(sensor)
        .with(move |size| vec![("coefficient_ppm_per_k", size * (upper - lower))])
}

/// A box that still air cools.
pub fn box_in_still_air(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, size, tau) = (draw.below(3), draw.sign(), span(campaign) * draw.octaves(0.08, 0.25));
    let act = on_sensor(sensor, move |_, run, _, times| {
        convection::missing(&run.times, tau).iter().map(|left| times * size * left).collect()
    });
    Effect::new("box that still air cools", vec![named("warm_up", sensor)], act).in_sensor(sensor)
}
