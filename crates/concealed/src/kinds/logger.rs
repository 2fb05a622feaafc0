//! Logger, converter and loop: further ways to be late, to step and to be coarse.

use super::electronics::{late, moment};
use crate::draw::Draw;
use crate::effect::{Effect, named, on_sensor};
use crate::finer::quartz::Cubic;
use crate::finer::{average, clip, ticks};
use crate::scene::Campaign;

/// A loop with a digital integrator.
pub fn digital_integrator(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, share) = (draw.below(3), draw.between(0.15, 0.4));
    let lag = move |size: f64| 2e-3 * size;
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let at = |t: f64| run.along(&campaign.bench, sensor, t);
        let tick = lag(size) * share / (1.0 - share);
        run.times.iter().map(|t| ticks::integrated(at, *t, tick, share) - at(*t)).collect()
    });
    let accepted = vec![named("loop_bandwidth", sensor), named("delay", sensor)];
    Effect::new("loop with a digital integrator", accepted, act)
        .in_sensor(sensor)
        .with(move |size| vec![("lag_s", lag(size)), ("delay_s", lag(size))])
}

/// A converter whose filter has Hann's weights.
pub fn hann_filter(_: &Campaign, draw: &mut Draw) -> Effect {
    let sensor = draw.below(3);
    let delay = move |size: f64| 2e-3 * size;
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let at = |t: f64| run.along(&campaign.bench, sensor, t);
        run.times.iter().map(|t| average::hann_before(at, *t, 2.0 * delay(size)) - at(*t)).collect()
    });
    let accepted = vec![named("delay", sensor), named("loop_bandwidth", sensor)];
    Effect::new("converter's filter with Hann's weights", accepted, act)
        .in_sensor(sensor)
        .with(move |size| vec![("delay_s", delay(size)), ("lag_s", delay(size))])
}

/// A sawtooth of mean 0 between −1 and 1.
fn sawtooth(turns: f64) -> f64 {
    2.0 * turns.rem_euclid(1.0) - 1.0
}

/// A clock that a server sets now and then, to a moment that is late itself.
pub fn disciplined(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (offset, begin) = (0.01 * draw.sign(), draw.between(0.0, 1.0));
    let run = &campaign.runs[0];
    let period = run.step_s() * run.times.len() as f64 * draw.between(0.08, 0.2);
    let act = late(move |run, size| {
        run.times.iter().map(|t| size * offset * (1.0 + 0.06 * sawtooth(t / period + begin))).collect()
    });
    Effect::new("clock that a late server sets", vec!["clock_offset".into()], act)
        .with(move |size| vec![("offset_s", size * offset)])
}

/// A quartz of the cut AT in the temperature of the electronics.
pub fn at_cut(_: &Campaign, draw: &mut Draw) -> Effect {
    let (ppm, slope) = (3.0 * draw.sign(), draw.between(-0.01, 0.01));
    let act = late(move |run, size| {
        let rate = 1e-6 * ppm * size;
        let quartz = Cubic { rate, slope_per_k: slope * rate, cubic_per_k3: 1e-4 * rate };
        quartz.late(&run.times, |t| run.temperatures[1](t))
    });
    Effect::new("resampling by a quartz of the cut AT", vec!["clock_rate".into()], act)
        .with(move |size| vec![("rate_ppm", size * ppm)])
}

/// A knock after which the mount goes on creeping for a twelfth of the step.
pub fn creeping_step(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, height, at) = (draw.below(3), draw.sign(), moment(campaign, draw));
    let tau = campaign.runs[0].step_s() * draw.between(4.0, 15.0);
    let act = on_sensor(sensor, move |_, run, _, size| {
        let risen = |t: &f64| if *t < at { 0.0 } else { 1.0 - (-(t - at) / tau).exp() / 12.0 };
        run.times.iter().map(|t| size * height * risen(t)).collect()
    });
    Effect::new("step that creeps on", vec![named("reading_step", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| vec![("height_nt", size * height)])
}

/// A transient that the amplifier's ringing ends: to the other side in the next reading, and back.
pub fn ringing_spike(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, height, at) = (draw.below(3), draw.sign(), moment(campaign, draw));
    let back = draw.between(0.02, 0.05);
    let act = on_sensor(sensor, move |_, run, _, size| {
        let step = run.step_s();
        let felt = |t: &f64| match ((t - at) / step).round() as i64 {
            since @ 0..=3 => (-back).powi(since as i32),
            _ => 0.0,
        };
        run.times.iter().map(|t| size * height * felt(t)).collect()
    });
    Effect::new("transient that rings", vec![named("spike", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| vec![("height_nt", size * height)])
}

/// A reading in codes of a width, to which noise of a share of it was added before: what is added in all, nT.
fn dithered(reading_nt: f64, width_nt: f64, dither: f64) -> f64 {
    ((reading_nt / width_nt + dither).round() - reading_nt / width_nt) * width_nt
}

/// A converter with too few codes and a little noise before them, as makers add it against the staircase.
pub fn dither(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, seed) = (draw.below(3), draw.below(1 << 20) as u64);
    let act = on_sensor(sensor, move |_, run, plain, size| {
        let mut noise = Draw::new(&format!("dither/{}", run.id), seed);
        plain.iter().map(|reading| dithered(*reading, size, noise.between(-0.15, 0.15))).collect()
    });
    Effect::new("converter with too few codes and a little dither", vec![named("quantisation", sensor)], act)
        .in_sensor(sensor)
        .of_codes()
        .with(|size| vec![("width_nt", size)])
}

/// An output stage that ends softly, as its diodes begin to conduct over thousands of nT.
pub fn soft_end(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, width) = (draw.below(3), draw.between(2500.0, 4000.0));
    // A size of 1 takes 10 nT from fields of 40 000 nT.
    let level = move |size: f64| 40_000.0 - width * (10.0 * size / width).min(0.6).exp_m1().ln();
    let act = on_sensor(sensor, move |_, _, plain, size| {
        plain.iter().map(|reading| clip::clipped(*reading, level(size), width) - reading).collect()
    });
    let accepted = vec![named("saturation", sensor), named("clipping", sensor)];
    Effect::new("output stage that ends as its diodes conduct", accepted, act).in_sensor(sensor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sawtooth_has_the_moments_of_an_even_spread() {
        let all: Vec<f64> = (0..3000).map(|k| sawtooth(f64::from(k) / 300.0)).collect();
        let mean = |power: i32| all.iter().map(|x| x.powi(power)).sum::<f64>() / 3000.0;
        assert!(mean(1).abs() < 0.01 && (mean(2) - 1.0 / 3.0).abs() < 0.01);
    }

    /// The mean over a dither of ± d codes is the staircase with its edges sloped over 2 d.
    #[test]
    fn a_dither_slopes_the_edges() {
        let mean = |reading: f64| {
            let all = (0..2000).map(|k| dithered(reading, 2.0, -0.15 + 0.3 * (f64::from(k) + 0.5) / 2000.0));
            all.sum::<f64>() / 2000.0 + reading
        };
        assert!((mean(0.3) - 0.0).abs() < 1e-9 && (mean(1.8) - 2.0).abs() < 1e-9);
        for off in [-0.1, 0.0, 0.08] {
            let exact = 2.0 * (0.5 + off / 0.3);
            assert!((mean(1.0 + 2.0 * off) - exact).abs() < 2e-3, "{off}");
        }
    }
}
