//! Passes of vehicles: three shapes on three axes at any moment, of any duration.

use estimate::events::{Departures, correlate};
use nalgebra::Matrix3;
use physics::{EffectInstance, Kind};
use rayon::prelude::*;

use crate::Error;
use crate::algebra::square;
use crate::channel::{Channel, Reader};
use crate::fit::{Fit, Fitter};
use crate::level::{Rest, at_least_one};
use crate::proposal::Proposal;
use crate::waves::mean_step_s;

/// Durations are tried from so many steps on, each longer than the one before by this factor, to a share of
/// the recording or the longest that is plausible.
const SHORTEST: f64 = 1.5;
const LONGER: f64 = 1.5;
const LONGEST: f64 = 0.1;
/// Around the best of them so many more are tried to either side.
const FINER: i32 = 6;
/// The shapes end so many durations from their middle.
const REACH: f64 = 6.0;
/// Fewest rows of a recording.
const ROWS: usize = 24;

pub fn proposal(
    fitter: &Fitter<'_, '_>,
    fit: &Fit,
    rest: &Rest,
    all: &[Departures],
) -> Result<Option<Proposal>, Error> {
    let observed = &fitter.model.observed;
    let mut strongest: Option<(f64, usize, f64, f64)> = None;
    let mut looks = 0.0;
    let duration = Kind::VehiclePass.parameters().iter().find(|info| info.name == "duration_s");
    let plausible_s = duration.map_or(f64::INFINITY, |info| info.high);
    for (number, run) in observed.runs.iter().enumerate() {
        let Some(time) = run.time_s else { continue };
        // No vehicle passes what turns in the sunlight above the ground.
        if run.setting.context.angle("sun_azimuth").is_some() {
            continue;
        }
        let is_searched =
            |c: &Channel| c.run == number && matches!(c.reader, Reader::Sensor(_)) && c.rows.len() >= ROWS;
        let channels = observed.channels.iter().enumerate();
        let channels: Vec<(usize, &Channel)> = channels.filter(|(_, c)| is_searched(c)).collect();
        if channels.len() < 3 || !fitter.model.can_act(number, &still(None, 0.0, 1.0)) {
            continue;
        }
        let rows = channels.iter().map(|(_, c)| c.rows.len()).min().unwrap_or(0);
        let step = mean_step_s(time);
        let tried = |duration: f64| {
            let (gain, row) = strongest_row(&channels, all, rows, duration);
            (gain, row, duration)
        };
        let better = |a: (f64, usize, f64), b: (f64, usize, f64)| if b.0 > a.0 { b } else { a };
        let longer = std::iter::successors(Some(SHORTEST), |duration| Some(duration * LONGER));
        let longest = (LONGEST * rows as f64).min(plausible_s / step);
        let coarse: Vec<f64> = longer.take_while(|duration| *duration < longest).collect();
        looks += coarse.iter().map(|duration| 3.0 * rows as f64 / duration).sum::<f64>();
        let Some(best) = coarse.into_iter().map(tried).reduce(better) else { continue };
        // A large pass of not quite the right duration leaves what looks like further events.
        let fine = (1 - FINER..FINER).map(|k| best.2 * LONGER.powf(f64::from(k) / f64::from(FINER)));
        let (gain, row, duration) = fine.map(tried).fold(best, better);
        if strongest.is_none_or(|(most, ..)| gain > most) {
            strongest = Some((gain, number, time[channels[0].1.rows[row]], duration * step));
        }
    }
    let Some((_, number, time_s, duration_s)) = strongest else { return Ok(None) };
    let own = observed.channels.iter().zip(all).filter(|(channel, _)| channel.run == number);
    let scatter = own.map(|(_, departures)| departures.scatter).fold(1.0, f64::max);
    let effect = still(Some(observed.runs[number].recording.id.clone()), time_s, duration_s);
    let (effect, gain, rank) = fitter.sized(fit, &effect)?;
    let p = at_least_one(rest.p_of_event(gain, scatter, rank), looks);
    Ok(Some(Proposal::event(effect, &observed.runs[number].recording.id, p, gain, looks)))
}

/// The row at which a pass of a duration (in rows) gains most, and how much.
fn strongest_row(
    channels: &[(usize, &Channel)],
    all: &[Departures],
    rows: usize,
    duration: f64,
) -> (f64, usize) {
    let reach = (REACH * duration).ceil() as i64;
    let shape = |power: i32| -> Vec<f64> {
        let x = (-reach..=reach).map(|row| row as f64 / duration);
        x.map(|x| x.powi(power) / (1.0 + x * x).powf(2.5)).collect()
    };
    let shapes: Vec<Vec<f64>> = (0..3).map(shape).collect();
    let of_channel = |(at, _): &(usize, &Channel)| -> Option<Vec<f64>> {
        let departures = &all[*at];
        // What begins at a row has its middle `reach` rows later.
        let along: Vec<Vec<f64>> = shapes.iter().map(|shape| correlate(&departures.along, shape)).collect();
        let inverse = inverse(&shapes, &departures.response)?;
        let gain = |begin: usize| -> f64 {
            let a: [f64; 3] = std::array::from_fn(|k| along[k][begin]);
            (0..3).map(|i| (0..3).map(|j| a[i] * inverse[(i, j)] * a[j]).sum::<f64>()).sum()
        };
        Some((0..rows.saturating_sub(2 * reach as usize)).map(gain).collect())
    };
    let gains: Vec<Option<Vec<f64>>> = channels.par_iter().map(of_channel).collect();
    let mut sum = vec![0.0; rows];
    for of_channel in gains.iter().flatten() {
        sum[reach as usize..].iter_mut().zip(of_channel).for_each(|(sum, gain)| *sum += gain);
    }
    let most =
        |most: (f64, usize), (row, gain): (usize, &f64)| if *gain > most.0 { (*gain, row) } else { most };
    sum.iter().enumerate().fold((0.0, 0), most)
}

/// A pass without a field.
fn still(recording: Option<String>, time_s: f64, duration_s: f64) -> EffectInstance {
    EffectInstance {
        recording,
        ..EffectInstance::new(Kind::VehiclePass, None, [vec![0.0; 9], vec![time_s, duration_s]].concat())
    }
}

/// The inverse of the products of the whitened shapes; None where these run together.
fn inverse(shapes: &[Vec<f64>], response: &[f64]) -> Option<Matrix3<f64>> {
    let reversed: Vec<f64> = response.iter().rev().copied().collect();
    let white = |shape: &Vec<f64>| {
        let (before, behind) = (vec![0.0; response.len() - 1], vec![0.0; shape.len()]);
        correlate(&[&before[..], shape, &behind].concat(), &reversed)
    };
    let white: Vec<Vec<f64>> = shapes.iter().map(white).collect();
    let product = |i: usize, j: usize| white[i].iter().zip(&white[j]).map(|(a, b)| a * b).sum();
    Matrix3::from_fn(product).try_inverse().filter(|inverse| square(inverse.as_slice()).is_finite())
}
