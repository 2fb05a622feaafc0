//! In electronics and logger.

use std::sync::Arc;

use crate::draw::Draw;
use crate::effect::{Act, Effect, named, on_sensor};
use crate::finer::converter::{self, Weighing};
use crate::finer::quartz::Quartz;
use crate::finer::{loop2, thermal};
use crate::scene::{Campaign, Run};

/// Width of the converter's codes behind the rounding of the document, nT.
const LSB_NT: f64 = 0.01;

pub(super) fn span(campaign: &Campaign) -> f64 {
    campaign.runs.last().and_then(|run| run.times.last()).copied().unwrap_or(0.0)
}

/// A box that loses heat by conduction and radiation, switched on at the campaign's zero.
pub fn warm_up(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, size) = (draw.below(3), draw.sign());
    let tau = span(campaign) * draw.octaves(0.07, 0.25);
    let act = on_sensor(sensor, move |_, run, _, times| {
        let warmth = thermal::box_after_switch_on(&run.times, tau, 0.15);
        warmth.iter().map(|x| times * size * (1.0 - x)).collect()
    });
    Effect::new("box that warms by conduction and radiation", vec![named("warm_up", sensor)], act)
        .in_sensor(sensor)
}

/// An offset current of an amplifier that grows exponentially.
pub fn offset_temperature(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, coefficient, scale_k) = (draw.below(3), 0.1 * draw.sign(), draw.between(25.0, 60.0));
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let warm = |t: &f64| run.temperatures[1](*t) - campaign.reference_c[1];
        run.times.iter().map(|t| size * coefficient * scale_k * ((warm(t) / scale_k).exp() - 1.0)).collect()
    });
    let accepted = vec![named("offset_electronics_temperature", sensor)];
    Effect::new("amplifier's offset exponential in temperature", accepted, act)
        .in_sensor(sensor)
        .with(move |size| vec![("coefficient_nt_per_k", size * coefficient)])
}

/// A loop of second order. Its lag for slow fields is 2ζ/ω.
pub fn second_order_loop(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, damping) = (draw.below(3), draw.between(0.6, 0.9));
    let lag = move |size: f64| 2e-3 * size;
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let field = run.along_signal(&campaign.bench, sensor);
        let omega = 2.0 * damping / lag(size);
        let followed = loop2::followed(&field, &run.times, omega, damping, 30.0 / omega);
        followed.iter().zip(&run.times).map(|(y, t)| y - field(*t)).collect()
    });
    let accepted = vec![named("loop_bandwidth", sensor), named("delay", sensor)];
    Effect::new("feedback loop of second order", accepted, act)
        .in_sensor(sensor)
        .with(move |size| vec![("lag_s", lag(size)), ("delay_s", lag(size))])
}

/// A converter that weighs bit by bit, a high bit too light, the two below it a little as well.
pub fn wrong_bits(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, bit) = (draw.below(3), 17 + draw.below(3) as u32);
    let (second, third) = (0.3 * draw.between(-1.0, 1.0), 0.2 * draw.between(-1.0, 1.0));
    let weighing = move |size: f64| Weighing {
        lsb_nt: LSB_NT,
        errors: vec![(bit, size), (bit - 1, second * size), (bit - 2, third * size)],
    };
    let act = on_sensor(sensor, move |_, _, plain, size| {
        let weighing = weighing(size);
        plain.iter().map(|reading| weighing.error(*reading)).collect()
    });
    Effect::new("converter with bits of wrong weight", vec![named("differential_nonlinearity", sensor)], act)
        .in_sensor(sensor)
        .of_codes()
        .with(move |size| vec![("period_nt", weighing(size).period(bit))])
}

/// A converter without its lower bits, its codes uneven.
pub fn coarse_codes(_: &Campaign, draw: &mut Draw) -> Effect {
    let sensor = draw.below(3);
    let act = on_sensor(sensor, move |_, _, plain, size| {
        plain.iter().map(|reading| converter::coarse(*reading, size, 0.1)).collect()
    });
    Effect::new("converter with too few and uneven codes", vec![named("quantisation", sensor)], act)
        .in_sensor(sensor)
        .of_codes()
        .with(|size| vec![("width_nt", size)])
}

/// A feedback current that runs out.
pub fn saturation(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, power) = (draw.below(3), draw.between(7.0, 9.0));
    // A size of 1 flattens fields of 60 000 nT by 10 nT.
    let level = move |size: f64| 60_000.0 * (60_000.0 / (10.0 * size * power)).powf(1.0 / power);
    let act = on_sensor(sensor, move |_, _, plain, size| {
        let level = level(size);
        plain.iter().map(|m| m / (1.0 + (m / level).abs().powf(power)).powf(1.0 / power) - m).collect()
    });
    Effect::new("feedback current that runs out", vec![named("saturation", sensor)], act).in_sensor(sensor)
}

/// All sensors read too late by a time for each row.
pub(super) fn late(of: impl Fn(&Run, f64) -> Vec<f64> + Send + Sync + 'static) -> Act {
    Arc::new(move |campaign, _, size| {
        let one = |run: &Run| {
            let late = of(run, size);
            std::array::from_fn(|sensor| {
                let at = |t: f64| run.along(&campaign.bench, sensor, t);
                run.times.iter().zip(&late).map(|(t, late)| at(t - late) - at(*t)).collect()
            })
        };
        campaign.runs.iter().map(one).collect()
    })
}

/// A clock that is off, its ticks a little uneven: the field is read again where it was at the true moments.
pub fn clock_offset(_: &Campaign, draw: &mut Draw) -> Effect {
    let (offset, seed) = (0.01 * draw.sign(), draw.below(1 << 20) as u64);
    let act = late(move |run, size| {
        let mut ticks = Draw::new(&format!("ticks/{}", run.id), seed);
        run.times.iter().map(|_| size * offset * (1.0 + 0.02 * ticks.normal())).collect()
    });
    Effect::new("true resampling at another moment", vec!["clock_offset".into()], act)
        .with(move |size| vec![("offset_s", size * offset)])
}

/// A quartz that gains, and bends with the temperature of the electronics.
pub fn clock_rate(_: &Campaign, draw: &mut Draw) -> Effect {
    let ppm = 3.0 * draw.sign();
    let act = late(move |run, size| {
        let rate = 1e-6 * ppm * size;
        let quartz = Quartz { offset_s: 0.0, rate, parabola_per_k2: -1e-3 * rate };
        quartz.late(&run.times, |t| run.temperatures[1](t))
    });
    Effect::new("resampling by a quartz that gains and feels its temperature", vec!["clock_rate".into()], act)
        .with(move |size| vec![("rate_ppm", size * ppm)])
}

/// A moment between 25 and 75 % of a random run.
pub(super) fn moment(campaign: &Campaign, draw: &mut Draw) -> f64 {
    let run = &campaign.runs[draw.below(campaign.runs.len())];
    run.times[(run.times.len() as f64 * draw.between(0.25, 0.75)) as usize]
}

/// A knock: the channel settles to a new level within a few tenths of a step of time.
pub fn step(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, height, at) = (draw.below(3), draw.sign(), moment(campaign, draw));
    let act = on_sensor(sensor, move |_, run, _, size| {
        let tau = 0.3 * run.step_s();
        let risen = |t: &f64| if *t < at { 0.0 } else { 1.0 - 0.5 * (-(t - at) / tau).exp() };
        run.times.iter().map(|t| size * height * risen(t)).collect()
    });
    Effect::new("step that settles", vec![named("reading_step", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| vec![("height_nt", size * height)])
}

/// A transient that the next reading still feels a little.
pub fn spike(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, height, at) = (draw.below(3), draw.sign(), moment(campaign, draw));
    let act = on_sensor(sensor, move |_, run, _, size| {
        let step = run.step_s();
        let felt = |t: &f64| match ((t - at) / step).round() as i64 {
            0 => 1.0,
            1 => 0.03,
            _ => 0.0,
        };
        run.times.iter().map(|t| size * height * felt(t)).collect()
    });
    Effect::new("transient with a tail", vec![named("spike", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| vec![("height_nt", size * height)])
}
