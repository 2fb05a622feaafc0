//! Coarse codes, from the readings themselves: all of a sensor's are whole numbers of one width.
//!
//! Such codes are no part of what is predicted, which would jump with every error of the field, but of the
//! noise: width²/12 of each reading.

use common::{Axis, Document};
use estimate::sine::{power_along, power_at, sharpened};
use physics::{EffectInstance, Kind};
use std::f64::consts::TAU;

use crate::channel::Reader;
use crate::fit::Fit;
use crate::level::{at_least_one, looks_along};
use crate::model::{Model, State};
use crate::proposal::{Addition, Proposal};
use crate::what::named;
use crate::whitening::{NoiseModel, code_nt};

/// Most cells along a reading.
const CELLS: usize = 1 << 20;
/// Cells in the narrowest width.
const FINE: f64 = 2.0;
/// Fewest readings that show codes.
const FEWEST: usize = 30;
/// Codes count from this share of the noise on.
const COUNTS: f64 = 0.5;
/// Codes that the document declares count no more than once.
const DECLARED: f64 = 1.5;
/// Share of the largest power at which a width is looked at.
const STRIKING: f64 = 0.5;
/// How much closer to whole numbers readings are than their noise alone would leave them.
const CLOSER: f64 = 0.1;

/// Sensors whose readings come in codes that are coarse for their noise, and wider than declared.
pub fn proposals(document: &Document, model: &Model<'_>, noise: &NoiseModel, fit: &Fit) -> Vec<Proposal> {
    Axis::ALL.into_iter().filter_map(|axis| of_sensor(document, model, noise, fit, axis)).collect()
}

fn of_sensor(
    document: &Document,
    model: &Model<'_>,
    noise: &NoiseModel,
    fit: &Fit,
    axis: Axis,
) -> Option<Proposal> {
    if fit.state.effects.iter().any(|effect| effect.kind == Kind::Quantisation && effect.axis == Some(axis)) {
        return None;
    }
    let (mut x, mut std, mut declared, mut gain) = (Vec::new(), f64::INFINITY, 0.0_f64, 0.0);
    for (number, channel) in model.observed.channels.iter().enumerate() {
        if channel.reader != Reader::Sensor(axis) {
            continue;
        }
        let (basic, _) = model.setting(&fit.state, channel.run);
        let sensitivity = basic.sensors[axis.index()].sensitivity;
        x.extend(channel.readings.iter().map(|reading| reading * sensitivity));
        std = std.min(noise.std_nt[number]);
        declared = declared.max(code_nt(document, &model.observed, channel));
        gain += channel.rows.len() as f64 / (12.0 * noise.std_nt[number].powi(2));
    }
    if x.len() < FEWEST {
        return None;
    }
    let (width, p) = width(&x, std, declared)?;
    let effect = EffectInstance::new(Kind::Quantisation, Some(axis), vec![width]);
    let (name, addition) = (named(&effect), Addition::Effect(effect));
    Some(Proposal { name, addition, p, gain: gain * width * width, looks: 1.0, local: false, group: None })
}

/// Standard uncertainty of a sensor's width of codes, nT, that of its sensitivity apart: of n readings x
/// whose phases 2πx/q scatter by σ, that of the frequency 1/q is σ/(2π √(n var x)).
pub fn width_std(model: &Model<'_>, state: &State, codes: &EffectInstance) -> f64 {
    let (Some(axis), [width]) = (codes.axis, &codes.parameters[..]) else { return 0.0 };
    let mut x = Vec::new();
    for channel in model.observed.channels.iter().filter(|channel| channel.reader == Reader::Sensor(axis)) {
        let (basic, _) = model.setting(state, channel.run);
        let sensitivity = basic.sensors[axis.index()].sensitivity;
        x.extend(channel.readings.iter().map(|reading| reading * sensitivity));
    }
    let count = x.len() as f64;
    let mean = x.iter().sum::<f64>() / count;
    let squares: f64 = x.iter().map(|x| (x - mean).powi(2)).sum();
    let share = power_at(&x, &vec![1.0; x.len()], 1.0 / width) / (count * count);
    let scatter = ((1.0 - share).max(0.0) / share.max(f64::MIN_POSITIVE)).sqrt();
    width * width * scatter / (TAU * squares.sqrt())
}

/// The width of which all readings are whole numbers, nT, and the probability of such a one by chance.
///
/// Of n readings x the power R² = |Σ exp(2πi x/q)|²/n² is one. Noise of the standard deviation σ alone leaves
/// exp(−4π²σ²/q²) at most, wherever the field is held; where it is spread, exp(−n R²) is the probability of
/// as much.
fn width(x: &[f64], std: f64, declared: f64) -> Option<(f64, f64)> {
    let (low, high) = x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let range = high - low;
    let largest = Kind::Quantisation.parameters()[0].high.min(0.5 * range);
    let least = (COUNTS * std).max(DECLARED * declared).max(2.0 * FINE * range / CELLS as f64);
    if !(range.is_finite() && least > 0.0 && largest > least) {
        return None;
    }
    let cell = least / FINE;
    let points = ((2.0 * range / cell).ceil() as usize).next_power_of_two();
    let grid = 1.0 / (points as f64 * cell);
    let count = x.len() as f64;
    let ones = vec![1.0; x.len()];
    let power = power_along(x, &ones, cell, points);
    let (from, to) = ((1.0 / largest / grid).ceil() as usize, (1.0 / least / grid).floor() as usize);
    let striking = (from..=to.min(power.len() - 1)).filter(|k| power[*k] > STRIKING * count * count);
    let share = |frequency: f64| power_at(x, &ones, frequency) / (count * count);
    let slope = slope(x);
    // Readings that are mostly alike, as in a shield, are striking at every frequency and close to whole
    // numbers of none: what the share can be at most about four places tells most of those without looking at
    // all between.
    let could_be = |k: &usize| {
        let least = 1.0 - CLOSER * (1.0 - (-(TAU * std * (*k as f64 + 1.0) * grid).powi(2)).exp());
        [-0.75, -0.25, 0.25, 0.75].into_iter().any(|off| {
            let most = share((*k as f64 + off) * grid).sqrt() + 0.25 * grid * slope;
            most * most > least
        })
    };
    striking
        .filter(could_be)
        .map(|k| sharpened(k as f64 * grid, grid, share))
        .find(|(frequency, share)| {
            let of_noise = (-(TAU * std * frequency).powi(2)).exp();
            1.0 - share < CLOSER * (1.0 - of_noise)
        })
        .map(|(frequency, share)| {
            let looks = 3.0 * looks_along(x, frequency, 2.0 * count * share);
            (1.0 / frequency, at_least_one((-count * share).exp(), looks))
        })
}

/// How fast |Σ exp(2πi ν x)|/n changes with ν at most: 2π times the mean distance from any place, here from
/// the median.
fn slope(x: &[f64]) -> f64 {
    let mut sorted = x.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    TAU * x.iter().map(|x| (x - median).abs()).sum::<f64>() / x.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_changes_no_faster_than_its_slope() {
        let x: Vec<f64> = (0..200).map(|k| if k % 3 == 0 { f64::from(k * k) } else { 0.1 }).collect();
        let (ones, slope) = (vec![1.0; x.len()], slope(&x));
        let root = |frequency: f64| power_at(&x, &ones, frequency).sqrt() / x.len() as f64;
        for k in 0..1000 {
            let (at, step) = (1e-6 * f64::from(k), 3e-7);
            assert!((root(at + step) - root(at)).abs() <= slope * step, "{at}");
        }
    }

    #[test]
    fn codes_are_found_and_fields_that_are_held_are_no_codes() {
        let mut stream = noise::Stream::new(1, "lattice");
        let fields: Vec<f64> =
            (0..300).map(|k| 20_000.0 * (0.37 * f64::from(k)).sin() + 0.3 * stream.normal()).collect();
        let coarse = |width: f64| fields.iter().map(|b| (b / width).round() * width).collect::<Vec<f64>>();
        for q in [0.4, 2.5] {
            let (found, p) = width(&coarse(q), 0.3, 0.01).expect("codes");
            assert!((found / q - 1.0).abs() < 1e-5 && p < 1e-6, "{found} for {q}, p = {p}");
        }
        assert!(width(&coarse(0.01), 0.3, 0.01).is_none());
        assert!(width(&fields, 0.3, 0.0).is_none());
        let held: Vec<f64> =
            (0..300).map(|k| [-30_000.0, 10.0, 30_000.0][k % 3] + 0.3 * stream.normal()).collect();
        assert!(width(&held, 0.3, 0.0).is_none());
    }
}
