//! What repeats along a sensor's own reading: codes that differ in width, and codes that are coarse.

use common::Axis;
use estimate::sine::{Series, Strongest, strongest};
use physics::{EffectInstance, Kind};
use rayon::prelude::*;

use crate::Error;
use crate::algebra::square;
use crate::channel::Reader;
use crate::fit::{Fit, Fitter};
use crate::level::{Rest, at_least_one, looks_along};
use crate::proposal::{Addition, Proposal};
use crate::what::named;

/// Most cells along a reading.
const CELLS: usize = 1 << 20;
/// Cells in the shortest period.
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
    let (sine, gain, rank) = crate::events::fitted(fitter, fit, &sine)?;
    let amplitude = sine.parameters[0].hypot(sine.parameters[1]);
    found.push(proposal(sine, at_least_one(rest.p(gain, rank), looks), gain, looks));
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
        found.push(proposal(staircase(width), p, gain, looks));
    }
    Ok(found)
}

fn proposal(effect: EffectInstance, p: f64, gain: f64, looks: f64) -> Proposal {
    Proposal {
        name: named(&effect),
        addition: Addition::Effect(effect),
        p,
        gain,
        looks,
        local: false,
        group: None,
    }
}
