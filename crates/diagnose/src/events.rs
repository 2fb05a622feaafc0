//! What happens at one moment: single readings, steps, readings that freeze, passes of vehicles.
//!
//! Matched filters go over all rows by Fourier transform, with the noise's response as it is in the middle of
//! a recording; what they find is then held against the residual exactly.

mod freeze;
mod pass;
mod settle;

pub use settle::settled_in_time;

use common::Axis;
use estimate::events::{Departures, Product};
use physics::{EffectInstance, Kind, Parameter};
use rayon::prelude::*;
use std::cmp::Ordering;

use crate::Error;
use crate::algebra::{columns, orthonormal};
use crate::channel::{Channel, Reader};
use crate::fit::{Fit, Fitter};
use crate::level::{Rest, at_least_one};
use crate::model::Single;
use crate::model::named;
use crate::proposal::{Addition, Proposal};

/// Jumps are no more than this share of the rows.
const RARE: f64 = 0.05;

/// Single readings are looked at beside the strongest from this share of its gain on, so many at most.
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

impl Best {
    fn consider(&mut self, other: Self) {
        if other.gain > self.gain {
            *self = other;
        }
    }
}

/// The most striking events of each kind, with the probability of such a one by chance over all rows.
pub fn proposals(fitter: &Fitter<'_, '_>, fit: &Fit, rest: &Rest) -> Result<Vec<Proposal>, Error> {
    let basis = orthonormal(&fit.jacobian)?;
    let observed = &fitter.model.observed;
    let all: Vec<Departures> = observed
        .channels
        .par_iter()
        .enumerate()
        .map(|(number, channel)| {
            let own = columns(&basis).map(|column| &column[channel.range()]);
            Departures::of(&fit.white[channel.range()], fitter.noise.response(number), own)
        })
        .collect();
    // What a step of a channel's whole recording is: what a step in an earlier recording goes on as.
    let whole: Vec<Product> = all.iter().map(Departures::whole).collect();
    let beside_jumps = beside_jumps(fitter, fit)?;
    let (mut spike, mut step, mut stays) = (Best::default(), Best::default(), Best::default());
    let mut looks = 0.0;
    let mut singles: Vec<Best> = Vec::new();
    for (number, (channel, departures)) in observed.channels.iter().zip(&all).enumerate() {
        let rows = channel.rows.len();
        let best = |gains: &[f64], row: usize| Best { gain: gains[row], channel: number, row };
        let gains = departures.spikes();
        for row in (0..rows).rev().filter(|row| !beside_jumps[channel.at + row]) {
            singles.push(best(&gains, row));
            spike.consider(best(&gains, row));
            looks += 1.0;
        }
        if observed.runs[channel.run].time_s.is_none() || matches!(channel.reader, Reader::Scalar) {
            continue;
        }
        let [earlier, later] = of_same_sensor(fitter, number);
        // Also between recordings, that is, from a first row on; in the earliest that is the sensor's offset.
        let mut search = |most: &mut Best, beyond: &Product| {
            let gains = departures.steps(beyond);
            let first = (!earlier.is_empty()).then_some(0);
            looks += rows as f64;
            let places = first.into_iter().chain(2..rows.saturating_sub(1));
            places.rev().for_each(|row| most.consider(best(&gains, row)));
        };
        search(&mut step, &Product::default());
        if !later.is_empty() {
            let mut beyond = Product::default();
            later.iter().for_each(|other| beyond.add(&whole[*other]));
            search(&mut stays, &beyond);
        }
    }
    let mut found = Vec::new();
    let steps = [(step, Kind::ReadingStep, true), (stays, Kind::ReadingStep, false)];
    let singles = isolated(singles, spike).into_iter().map(|best| (best, Kind::Spike, true));
    for (best, kind, alone) in singles.chain(steps).filter(|(best, ..)| best.gain > 0.0) {
        let scatter = all[best.channel].scatter;
        let channel = &observed.channels[best.channel];
        let row = channel.rows[best.row];
        // What steps in one sensor may do so in all; a step of the field's magnitude may be that of any sensor.
        let beside = observed.channels.iter().enumerate().filter(|(_, other)| other.run == channel.run);
        let mut places: Vec<(Best, Option<Axis>)> = match (kind, channel.reader) {
            (Kind::ReadingStep, Reader::Sensor(_)) => beside
                .filter_map(|(number, other)| {
                    let row = other.rows.iter().position(|at| *at == row)?;
                    Some((Best { channel: number, row, ..best }, Some(other.axis()?)))
                })
                .collect(),
            (Kind::ReadingStep, Reader::Magnitude) => Axis::ALL.map(|axis| (best, Some(axis))).to_vec(),
            (_, Reader::Sensor(axis)) => vec![(best, Some(axis))],
            _ => vec![(best, None)],
        };
        // In the other channels the moment is known from the one in which it was found: each is one look.
        let beside = places.len() as f64;
        places.sort_by_key(|(place, _)| place.channel != best.channel);
        let mut by_chance = 0.0;
        for place in places {
            let searched = place.0.channel == best.channel;
            let own = if searched { looks } else { beside };
            let Some(proposal) = moment(fitter, fit, (rest, scatter), place, (kind, alone), own)? else {
                continue;
            };
            if searched {
                by_chance = proposal.p;
            }
            found.push(Proposal { p: proposal.p.max(by_chance), ..proposal });
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

/// Rows beside which effects jump, far more than elsewhere in the channel: a reading there tells the moment.
fn beside_jumps(fitter: &Fitter<'_, '_>, fit: &Fit) -> Result<Vec<bool>, Error> {
    let mut found = vec![false; fitter.model.observed.rows];
    let mut without = fit.state.clone();
    without.keep_effects(|number| fit.state.effects[number].kind == Kind::Spike);
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

/// Channels of the same sensor in earlier and in later recordings.
fn of_same_sensor(fitter: &Fitter<'_, '_>, number: usize) -> [Vec<usize>; 2] {
    let observed = &fitter.model.observed;
    let begins = |channel: &Channel| {
        let run = &observed.runs[channel.run];
        Some(run.time_s?.first()? + run.setting.context.clock_s)
    };
    let own = &observed.channels[number];
    let all = observed.channels.iter().enumerate().filter(|(_, other)| other.reader == own.reader);
    [Ordering::Less, Ordering::Greater].map(|side| {
        let there = |(_, other): &(usize, &Channel)| {
            begins(other).zip(begins(own)).and_then(|(other, own)| other.partial_cmp(&own)) == Some(side)
        };
        all.clone().filter(there).map(|(k, _)| k).collect()
    })
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
                recording: alone.then(|| run.recording.id.clone()),
                ..EffectInstance::new(kind, Some(axis), vec![0.0, time[channel.rows[best.row]] + clock_s])
            };
            let with = fitter.model.with(&fit.state, effect.clone());
            let amplitude = [Parameter::Effect(with.effects.len() - 1, 0)];
            (Addition::Effect(effect), fitter.model.derivatives(&with, &amplitude)?.remove(0))
        }
        _ => {
            let row = channel.at + best.row;
            let what = format!(
                "reading {} of {} in \"{}\"",
                channel.rows[best.row], channel.column, run.recording.id
            );
            (Addition::Single(Single { what, row, height_nt: 0.0 }), fitter.model.one_at(row))
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
    let later = if alone { "" } else { " and later" };
    let name = match &mut addition {
        Addition::Effect(effect) => {
            effect.parameters[0] = height;
            format!("{} in \"{}\"{later}", named(effect), run.recording.id)
        }
        Addition::Single(single) => {
            single.height_nt = height;
            single.what.clone()
        }
    };
    let p = at_least_one(rest.p_of_event(exact.gain, scatter, exact.rank), looks);
    let group = match (&addition, axis) {
        (Addition::Single(_), _) => Some("single readings".into()),
        (Addition::Effect(_), Some(axis)) if kind == Kind::Spike => {
            Some(format!("single readings of {axis}"))
        }
        // Between recordings in two orientations steps in two sensors may be equivalent: each is a name of its own.
        (Addition::Effect(effect), Some(_))
            if matches!(channel.reader, Reader::Sensor(_)) && best.row > 0 =>
        {
            Some(format!("step at {} s in \"{}\"{later}", effect.parameters[1], run.recording.id))
        }
        _ => None,
    };
    Ok(Some(Proposal { name, addition, p, gain: exact.gain, looks, local: true, group }))
}
