//! What happens at one moment: single readings, steps, readings that freeze, passes of vehicles.
//!
//! Matched filters go over all rows by Fourier transform, with the noise's response as it is in the middle of a recording; what they
//! find is then held against the residual exactly.

mod freeze;
mod pass;
mod settle;

pub use settle::settled_in_time;

use common::Axis;
use estimate::stats::{chi_squared_quantile, median};
use physics::{EffectInstance, Kind, Parameter, Role};
use rayon::prelude::*;
use std::sync::Arc;

use crate::Error;
use crate::channel::{Channel, Reader};
use crate::fit::{Fit, Fitter, orthonormal, square};
use crate::level::{Rest, at_least_one};
use crate::matched::correlate;
use crate::model::Column;
use crate::proposal::{Addition, Proposal};
use crate::what::named;

/// A departure of which the base model leaves less than this share is not looked for.
const LEFT: f64 = 1e-3;
/// Jumps are no more than this share of the rows.
const RARE: f64 = 0.05;

/// A departure of one nT in each row of a channel, against its whitened residual.
struct Departures {
    /// The noise's response to one departure.
    response: Vec<f64>,
    /// Σ of the whitened residual times the response from each row on.
    along: Vec<f64>,
    /// The same with each column of a basis of the base model.
    within: Vec<Vec<f64>>,
    /// Robust variance of the whitened residual, at least one (the square of the Birge ratio): an event must be significant against the
    /// scatter that there is, not against the noise alone.
    scatter: f64,
}

impl Departures {
    fn of(fitter: &Fitter<'_, '_>, fit: &Fit, basis: &faer::Mat<f64>, number: usize) -> Self {
        let channel = &fitter.model.observed.channels[number];
        let response = fitter.noise.response(number);
        let white = &fit.white[channel.range()];
        let along = correlate(white, &response);
        let squares: Vec<f64> = white.iter().map(|w| w * w).collect();
        let scatter = (median(&squares) / chi_squared_quantile(0.5, 1.0)).max(1.0);
        let within = (0..basis.ncols())
            .map(|j| correlate(&basis.col_as_slice(j)[channel.range()], &response))
            .collect();
        Self { response, along, within, scatter }
    }

    /// Squared length of a departure in each row, and of one that stays from each row on.
    fn lengths(&self) -> [Vec<f64>; 2] {
        let rows = self.along.len();
        let (mut level, mut single, mut stays) = (0.0, 0.0, 0.0);
        let (mut one, mut step) = (vec![0.0; rows], vec![0.0; rows]);
        for i in 0..rows {
            let response = self.response.get(i).copied().unwrap_or(0.0);
            level += response;
            single += response * response;
            stays += level * level;
            (one[rows - 1 - i], step[rows - 1 - i]) = (single, stays);
        }
        [one, step]
    }
}

/// Single readings are looked at together with the strongest from this share of its gain on, and no more of them than that.
const AS_STRONG: f64 = 0.1;
const MOST_SINGLES: usize = 60;
/// Rows to either side of a single reading that belong to it.
const BESIDE: usize = 2;

/// A spike of up to so many codes may be the code beside the right one.
const CODES: f64 = 1.5;

/// The best row so far: gain and row.
#[derive(Clone, Copy, Default)]
struct Best {
    gain: f64,
    channel: usize,
    row: usize,
}

/// The most striking events of each kind, with the probability of such a one by chance over all rows.
pub fn proposals(fitter: &Fitter<'_, '_>, fit: &Fit, rest: &Rest) -> Result<Vec<Proposal>, Error> {
    let basis = orthonormal(&fit.jacobian)?;
    let observed = &fitter.model.observed;
    let all: Vec<Departures> = (0..observed.channels.len())
        .into_par_iter()
        .map(|number| Departures::of(fitter, fit, &basis, number))
        .collect();
    // What a step of a channel's whole recording is: what a step in an earlier recording goes on as.
    let whole: Vec<(f64, f64, Vec<f64>)> = all
        .iter()
        .map(|departures| {
            let within = departures.within.iter().map(|values| values.iter().sum()).collect();
            (departures.along.iter().sum(), departures.lengths()[1].first().copied().unwrap_or(0.0), within)
        })
        .collect();
    let beside_jumps = beside_jumps(fitter, fit)?;
    let (mut spike, mut step, mut stays) = (Best::default(), Best::default(), Best::default());
    let mut looks = 0.0;
    let mut singles: Vec<Best> = Vec::new();
    for (number, (channel, departures)) in observed.channels.iter().zip(&all).enumerate() {
        let [one, lasting] = departures.lengths();
        let rows = channel.rows.len();
        let timed = observed.runs[channel.run].time_s.is_some() && !matches!(channel.reader, Reader::Scalar);
        let later: Vec<usize> = later(fitter, number).collect();
        let mut sum = (0.0, vec![0.0; basis.ncols()]);
        let mut after = (0.0, 0.0, vec![0.0; basis.ncols()]);
        for other in &later {
            after.0 += whole[*other].0;
            after.1 += whole[*other].1;
            after.2.iter_mut().zip(&whole[*other].2).for_each(|(a, w)| *a += w);
        }
        for row in (0..rows).rev() {
            let within = |j: usize| departures.within[j][row];
            let consider = |best: &mut Best, along: f64, length: f64, inside: f64| {
                let left = length - inside;
                let gain = along * along / left;
                if left > LEFT * length && gain > best.gain {
                    *best = Best { gain, channel: number, row };
                }
            };
            let inside: f64 = (0..basis.ncols()).map(|j| within(j).powi(2)).sum();
            if !beside_jumps[channel.at + row] {
                let mut own = Best::default();
                consider(&mut own, departures.along[row], one[row], inside);
                singles.push(own);
                if own.gain > spike.gain {
                    spike = own;
                }
                looks += 1.0;
            }
            sum.0 += departures.along[row];
            (0..basis.ncols()).for_each(|j| sum.1[j] += within(j));
            if timed && row >= 2 && row + 2 <= rows {
                consider(&mut step, sum.0, lasting[row], square(&sum.1));
                looks += 1.0;
                if !later.is_empty() {
                    let inside = sum.1.iter().zip(&after.2).map(|(a, b)| (a + b).powi(2)).sum();
                    consider(&mut stays, sum.0 + after.0, lasting[row] + after.1, inside);
                    looks += 1.0;
                }
            }
        }
    }
    let mut found = Vec::new();
    let steps = [(step, Kind::ReadingStep, true), (stays, Kind::ReadingStep, false)];
    let singles = isolated(singles, spike).into_iter().map(|best| (best, Kind::Spike, true));
    for (best, kind, alone) in singles.chain(steps).filter(|(best, ..)| best.gain > 0.0) {
        let scatter = all[best.channel].scatter;
        // A step of the field's magnitude may be that of any sensor.
        let axes: Vec<Option<Axis>> = match (kind, observed.channels[best.channel].reader) {
            (_, Reader::Sensor(axis)) => vec![Some(axis)],
            (Kind::ReadingStep, Reader::Magnitude) => Axis::ALL.map(Some).to_vec(),
            _ => vec![None],
        };
        for axis in axes {
            found.extend(moment(fitter, fit, (rest, scatter), (best, axis), (kind, alone), looks)?);
        }
    }
    found.extend(freeze::proposal(fitter, fit, rest, &all)?);
    found.extend(pass::proposal(fitter, fit, rest, &all)?);
    Ok(found)
}

/// Single readings beside the strongest: those that depart as much as a share of it, each by itself.
fn isolated(mut all: Vec<Best>, strongest: Best) -> Vec<Best> {
    all.retain(|one| one.gain > AS_STRONG * strongest.gain);
    if all.len() > MOST_SINGLES {
        return vec![strongest];
    }
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let mut kept: Vec<Best> = Vec::new();
    for one in all {
        let beside = |other: &Best| other.channel == one.channel && other.row.abs_diff(one.row) <= BESIDE;
        if !kept.iter().any(beside) {
            kept.push(one);
        }
    }
    kept
}

/// Rows beside which what effects add jumps, far more than elsewhere in the channel: a reading there tells the moment of the jump.
fn beside_jumps(fitter: &Fitter<'_, '_>, fit: &Fit) -> Result<Vec<bool>, Error> {
    let mut found = vec![false; fitter.model.observed.rows];
    let mut without = fit.state.clone();
    let spike: Vec<bool> = without.effects.iter().map(|effect| effect.kind == Kind::Spike).collect();
    let (mut of_effects, mut of_acts) = (spike.iter(), spike.iter());
    without.effects.retain(|_| of_effects.next() == Some(&true));
    without.acts.retain(|_| of_acts.next() == Some(&true));
    if without.effects.len() == fit.state.effects.len() {
        return Ok(found);
    }
    let added = fitter.model.change(&without, &fit.state)?;
    for channel in &fitter.model.observed.channels {
        let apart: Vec<f64> =
            added[channel.range()].windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
        let most = apart.iter().copied().fold(0.0, f64::max);
        let jumps: Vec<usize> = (0..apart.len()).filter(|row| apart[*row] > 0.5 * most).collect();
        if (jumps.len() as f64) < RARE * apart.len() as f64 {
            jumps.iter().for_each(|row| found[channel.at + row..=channel.at + row + 1].fill(true));
        }
    }
    Ok(found)
}

/// Channels of the same sensor in later recordings.
fn later<'f>(fitter: &'f Fitter<'_, '_>, number: usize) -> impl Iterator<Item = usize> + 'f {
    let observed = &fitter.model.observed;
    let begins = |run: usize| {
        let run = &observed.runs[run];
        run.time_s.and_then(|time| time.first()).map(|first| first + run.setting.context.clock_s)
    };
    let own = &observed.channels[number];
    observed
        .channels
        .iter()
        .enumerate()
        .filter(move |(_, other)| {
            other.reader == own.reader && begins(other.run) > begins(own.run) && begins(own.run).is_some()
        })
        .map(|(k, _)| k)
}

/// A spike or a step at a row, held against the residual exactly.
fn moment(
    fitter: &Fitter<'_, '_>,
    fit: &Fit,
    (rest, scatter): (&Rest, f64),
    (best, axis): (Best, Option<Axis>),
    (kind, alone): (Kind, bool),
    looks: f64,
) -> Result<Option<Proposal>, Error> {
    let observed = &fitter.model.observed;
    let channel: &Channel = &observed.channels[best.channel];
    let run = &observed.runs[channel.run];
    let (mut addition, column) = match (axis, run.time_s) {
        (Some(axis), Some(time)) => {
            let clock_s = if alone { 0.0 } else { run.setting.context.clock_s };
            let effect = EffectInstance {
                kind,
                axis: Some(axis),
                column: None,
                recording: alone.then(|| run.recording.id.clone()),
                within: Default::default(),
                parameters: vec![0.0, time[channel.rows[best.row]] + clock_s],
            };
            let with = fitter.model.with(&fit.state, effect.clone());
            let amplitude = [Parameter::Effect(with.effects.len() - 1, 0)];
            (Addition::Effect(effect), fitter.model.derivatives(&with, &amplitude)?.remove(0))
        }
        _ => {
            let mut values = vec![0.0; observed.rows];
            values[channel.at + best.row] = 1.0;
            let what = format!(
                "reading {} of {} in \"{}\"",
                channel.rows[best.row], channel.column, run.recording.id
            );
            (
                Addition::Column(Column {
                    what,
                    follows: None,
                    values: Arc::new(values.clone()),
                    coefficient: 0.0,
                }),
                values,
            )
        }
    };
    let exact = fitter.gain_of(fit, &[column])?;
    let height = exact.coefficients[0];
    // Where a field is close to the edge between two codes, a coarse converter reads the one or the other.
    let coarse = |effect: &EffectInstance| {
        effect.kind == Kind::Quantisation
            && channel.reader == effect.axis.map_or(Reader::Scalar, Reader::Sensor)
            && height.abs() < CODES * effect.parameters[0]
    };
    if kind == Kind::Spike && fit.state.effects.iter().any(coarse) {
        return Ok(None);
    }
    let name = match &mut addition {
        Addition::Effect(effect) => {
            effect.parameters[0] = height;
            if alone {
                format!("{} in \"{}\"", named(effect), run.recording.id)
            } else {
                format!("{} in \"{}\" and later", named(effect), run.recording.id)
            }
        }
        Addition::Column(column) => {
            column.coefficient = height;
            column.what.clone()
        }
    };
    let p = at_least_one(rest.p(exact.gain / scatter, exact.rank), looks);
    Ok(Some(Proposal { name, addition, p, gain: exact.gain, looks, local: true }))
}

/// An effect with its amplitudes fitted to a residual, and what that gains.
pub fn fitted(
    fitter: &Fitter<'_, '_>,
    fit: &Fit,
    effect: &EffectInstance,
) -> Result<(EffectInstance, f64, usize), Error> {
    let with = fitter.model.with(&fit.state, effect.clone());
    let number = with.effects.len() - 1;
    let amplitudes: Vec<usize> = effect
        .kind
        .parameters()
        .iter()
        .enumerate()
        .filter(|(_, info)| info.role == Role::Amplitude)
        .map(|(k, _)| k)
        .collect();
    let parameters: Vec<Parameter> = amplitudes.iter().map(|k| Parameter::Effect(number, *k)).collect();
    let gain = fitter.gain_of(fit, &fitter.model.derivatives(&with, &parameters)?)?;
    let mut effect = effect.clone();
    for (at, value) in amplitudes.iter().zip(&gain.coefficients) {
        effect.parameters[*at] = *value;
    }
    Ok((effect, gain.gain, gain.rank))
}
