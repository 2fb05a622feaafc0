//! Codes of a sensor's reading: what repeats along it, codes that differ in width and codes that are coarse; and coarse
//! codes from the readings themselves, which are whole numbers of one width.
//!
//! The latter are no part of what is predicted, which would jump with every error of the field, but of the noise:
//! width²/12 of each reading.

use common::Axis;
use estimate::sine::{Series, Strongest, power_along, power_at, sharpened, strongest};
use physics::{EffectInstance, Kind};
use rayon::prelude::*;
use std::f64::consts::TAU;

use crate::Error;
use crate::algebra::square;
use crate::channel::{Channel, Reader};
use crate::fit::{Fit, Fitter};
use crate::level::{Rest, at_least_one, looks_along};
use crate::model::{Model, State};
use crate::proposal::Proposal;
use crate::whitening::{NoiseModel, code_nt};

/// Most cells along a reading.
const CELLS: usize = 1 << 20;
/// Cells in the shortest period, or the narrowest width.
const FINE: f64 = 2.0;
/// Period over the standard deviation of the noise below which codes do not show: noise before the converter leaves
/// exp(−2π²σ²/period²) of a sine of them, here 0.7 %.
const BLURRED: f64 = 2.0;
/// Widths tried about one that was found, to either side, over the distance in which all codes slip by one.
const WIDTHS: i32 = 32;
/// Least amplitude of the sine in the error of coarse codes, over their width: without noise it is 1/π.
const ROUNDED: f64 = 0.1;

/// Both explanations of the strongest period of each sensor.
pub fn proposals(fitter: &Fitter<'_, '_>, fit: &Fit, rest: &Rest) -> Result<Vec<Proposal>, Error> {
    let axes: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| fitter.model.reads(*axis)).collect();
    let found: Vec<Vec<Proposal>> =
        axes.par_iter().map(|axis| of_sensor(fitter, fit, rest, *axis)).collect::<Result<_, _>>()?;
    Ok(found.concat())
}

fn of_sensor(fitter: &Fitter<'_, '_>, fit: &Fit, rest: &Rest, axis: Axis) -> Result<Vec<Proposal>, Error> {
    let model = fitter.model;
    let observed = &model.observed;
    let predicted = model.predicted(&fit.state)?;
    let (mut x, mut y) = (Vec::new(), Vec::new());
    let (mut length, mut std) = (0.0, f64::INFINITY);
    for (number, channel) in observed.channels.iter().enumerate() {
        if channel.reader != Reader::Sensor(axis) {
            continue;
        }
        // The sensitivity as it stands: what the converter gets is the reading times that.
        let (basic, _) = model.setting(&fit.state, channel.run);
        let scale = basic.sensors[axis.index()].sensitivity / channel.to_nt;
        x.extend(predicted[channel.range()].iter().map(|reading| reading * scale));
        y.extend(fitter.noise.filtered(number, &fit.white[channel.range()]));
        length += channel.rows.len() as f64 * square(&fitter.noise.response(number));
        std = std.min(fitter.noise.std_nt[number]);
    }
    let (low, high) = x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let range = high - low;
    let infos = Kind::DifferentialNonlinearity.parameters();
    let longest = infos[2].high.min(range);
    // Within a coarse code all readings are one.
    let is_coarse = |e: &&EffectInstance| e.kind == Kind::Quantisation && e.axis == Some(axis);
    let coarse = fit.state.effects.iter().find(is_coarse).map(|effect| effect.parameters[0]);
    let least = coarse.map_or(0.02, |width| 2.0 * width);
    let shortest = (BLURRED * std).max(least).max(2.0 * FINE * range / CELLS as f64);
    if !(range > 0.0 && longest > 2.0 * shortest && x.len() > 8) {
        return Ok(Vec::new());
    }
    let cell = shortest / FINE;
    let points = ((2.0 * range / cell).ceil() as usize).next_power_of_two();
    let series = [Series { x, y: &y, weight: 2.0 / length }];
    let Some(found) = strongest(&series, cell, points, (1.0 / longest, 1.0 / shortest)) else {
        return Ok(Vec::new());
    };
    let Strongest { frequency, power, band } = found;
    // Three sensors are gone through.
    let looks = 3.0 * looks_along(&series[0].x, band, power);
    if at_least_one(rest.p(power, 2), looks) > 0.5 {
        return Ok(Vec::new());
    }
    let period = 1.0 / frequency;
    let mut found = Vec::new();
    let mut still = vec![0.0; infos.len()];
    still[2] = period;
    let sine = EffectInstance::new(Kind::DifferentialNonlinearity, Some(axis), still);
    let (sine, gain, rank) = fitter.sized(fit, &sine)?;
    let amplitude = sine.parameters[0].hypot(sine.parameters[1]);
    found.push(Proposal::of(sine, at_least_one(rest.p(gain, rank), looks), gain, looks));
    if amplitude < ROUNDED * period || coarse.is_some() {
        return Ok(found);
    }
    let slip = period / range * period;
    let staircase = |width: f64| EffectInstance::new(Kind::Quantisation, Some(axis), vec![width]);
    let mut best: Option<(f64, f64)> = None;
    for k in -WIDTHS..=WIDTHS {
        let width = period + slip * f64::from(k) / f64::from(WIDTHS);
        let gain = fitter.gain_as_it_is(fit, &staircase(width))?;
        if best.is_none_or(|(most, _)| gain > most) {
            best = Some((gain, width));
        }
    }
    if let Some((gain, width)) = best.filter(|(gain, _)| *gain > 0.0) {
        let p = at_least_one(rest.p(gain, 1), looks);
        found.push(Proposal::of(staircase(width), p, gain, looks));
    }
    Ok(found)
}

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
pub fn coarse(model: &Model<'_>, noise: &NoiseModel, fit: &Fit) -> Vec<Proposal> {
    Axis::ALL.into_iter().filter_map(|axis| coarse_of(model, noise, fit, axis)).collect()
}

fn coarse_of(model: &Model<'_>, noise: &NoiseModel, fit: &Fit, axis: Axis) -> Option<Proposal> {
    if fit.state.effects.iter().any(|effect| effect.kind == Kind::Quantisation && effect.axis == Some(axis)) {
        return None;
    }
    let x = readings(model, &fit.state, axis);
    if x.len() < FEWEST {
        return None;
    }
    let (mut std, mut declared, mut gain) = (f64::INFINITY, 0.0_f64, 0.0);
    let own = model.observed.channels.iter().zip(&noise.std_nt);
    for (channel, noise_nt) in own.filter(|(channel, _)| channel.reader == Reader::Sensor(axis)) {
        std = std.min(*noise_nt);
        declared = declared.max(code_nt(&model.observed, channel));
        gain += channel.rows.len() as f64 / (12.0 * noise_nt.powi(2));
    }
    let (width, p) = width(&x, std, declared)?;
    let effect = EffectInstance::new(Kind::Quantisation, Some(axis), vec![width]);
    Some(Proposal::of(effect, p, gain * width * width, 1.0))
}

/// All readings of a sensor, nT by its sensitivity at a state.
fn readings(model: &Model<'_>, state: &State, axis: Axis) -> Vec<f64> {
    let own = model.observed.channels.iter().filter(|channel| channel.reader == Reader::Sensor(axis));
    let of = |channel: &Channel| {
        let sensitivity = model.setting(state, channel.run).0.sensors[axis.index()].sensitivity;
        channel.readings.iter().map(|reading| reading * sensitivity).collect::<Vec<f64>>()
    };
    own.flat_map(of).collect()
}

/// Standard uncertainty of a sensor's width of codes, nT, that of its sensitivity apart: of n readings x
/// whose phases 2πx/q scatter by σ, that of the frequency 1/q is σ/(2π √(n var x)).
pub fn width_std(model: &Model<'_>, state: &State, codes: &EffectInstance) -> f64 {
    let (Some(axis), [width]) = (codes.axis, &codes.parameters[..]) else { return 0.0 };
    let x = readings(model, state, axis);
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

/// How fast |Σ exp(2πi ν x)|/n changes with ν at most: 2π times the mean distance from the median.
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
