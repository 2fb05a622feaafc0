//! Single readings and steps: one departure at every row of every channel, against the whitened residual.

use faer::Mat;
use physics::{EffectInstance, Kind};
use std::sync::Arc;

use crate::Error;
use crate::fit::{Fit, Fitter};
use crate::level::{Rest, at_least_one};
use crate::model::Column;
use crate::observed::Reader;
use crate::search::{Addition, Proposal};

/// Most readings of a channel whose responses are gone through.
const LONGEST: usize = 3000;
/// Directions of scaled columns with less than this share are rounding.
const ROUNDING: f64 = 1e-10;

/// The most striking spike and step of all channels, with the probability of such a one by chance over all rows.
pub fn proposals(fitter: &Fitter<'_, '_>, fit: &Fit, rest: &Rest) -> Result<Vec<Proposal>, Error> {
    let basis = orthonormal(&fit.jacobian)?;
    let observed = &fitter.model.observed;
    let mut best: [Option<(f64, usize, usize, f64)>; 2] = [None, None];
    let mut looks = 0.0;
    for (number, channel) in observed.channels.iter().enumerate() {
        let rows = channel.rows.len();
        if rows > LONGEST {
            continue;
        }
        let responses = fitter.noise.responses(number, rows);
        let own = basis.as_ref().subrows(channel.at, rows);
        let white = Mat::from_fn(rows, 1, |i, _| fit.white[channel.at + i]);
        // Along the residual, and what is left of each response without the base model.
        let along = responses.transpose() * &white;
        let within = own.transpose() * &responses;
        let mut sum = (0.0, vec![0.0; rows], vec![0.0; own.ncols()]);
        for row in (0..rows).rev() {
            let left = squares(responses.col_as_slice(row)) - squares(within.col_as_slice(row));
            consider(&mut best[0], along[(row, 0)], left, number, row);
            looks += 1.0;
            sum.0 += along[(row, 0)];
            add(&mut sum.1, responses.col_as_slice(row));
            add(&mut sum.2, within.col_as_slice(row));
            if row >= 2 && row + 2 <= rows && observed.runs[channel.run].time_s.is_some() {
                let left = squares(&sum.1) - squares(&sum.2);
                consider(&mut best[1], sum.0, left, number, row);
                looks += 1.0;
            }
        }
    }
    let mut all = Vec::new();
    for (spike, found) in [true, false].into_iter().zip(best) {
        let Some((gain, number, row, height)) = found else { continue };
        let channel = &observed.channels[number];
        let run = &observed.runs[channel.run];
        let kind = if spike { Kind::Spike } else { Kind::ReadingStep };
        let addition = match (channel.reader, run.time_s) {
            (Reader::Sensor(axis), Some(time)) => Addition::Effect(EffectInstance {
                kind,
                axis: Some(axis),
                column: None,
                recording: Some(run.recording.id.clone()),
                parameters: vec![height, time[channel.rows[row]]],
            }),
            _ => {
                let mut values = vec![0.0; observed.rows];
                values[channel.at + row] = 1.0;
                let what = format!("reading {} of {} in \"{}\"", channel.rows[row], channel.column, run.recording.id);
                Addition::Column(Column { what, values: Arc::new(values), coefficient: height })
            }
        };
        let p = at_least_one(rest.p(gain, 1), looks);
        all.push(Proposal { name: format!("{} {}", kind.name(), run.recording.id), addition, p, gain, searched: 2.0, local: true });
    }
    Ok(all)
}

fn consider(best: &mut Option<(f64, usize, usize, f64)>, along: f64, left: f64, channel: usize, row: usize) {
    let gain = along * along / left;
    if left > 0.0 && left.is_normal() && best.is_none_or(|(most, ..)| gain > most) {
        *best = Some((gain, channel, row, along / left));
    }
}

fn squares(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum()
}

fn add(sum: &mut [f64], values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(s, v)| *s += v);
}

/// An orthonormal basis of columns.
pub fn orthonormal(columns: &Mat<f64>) -> Result<Mat<f64>, Error> {
    let lengths: Vec<f64> = (0..columns.ncols()).map(|j| squares(columns.col_as_slice(j)).sqrt()).collect();
    let kept: Vec<usize> = (0..columns.ncols()).filter(|j| lengths[*j] > 0.0).collect();
    let scaled = Mat::from_fn(columns.nrows(), kept.len(), |i, j| columns[(i, kept[j])] / lengths[kept[j]]);
    let gram = scaled.transpose() * &scaled;
    let failed = |reason: String| {
        Error::Estimate(estimate::Error::Decomposition { rows: kept.len(), columns: kept.len(), reason })
    };
    let eigen =
        gram.self_adjoint_eigen(faer::Side::Lower).map_err(|error| failed(format!("{error:?}")))?;
    let values: Vec<f64> = (0..kept.len()).map(|k| eigen.S().column_vector()[k]).collect();
    let along: Vec<usize> = (0..kept.len()).filter(|k| values[*k] > ROUNDING).collect();
    let directions = Mat::from_fn(kept.len(), along.len(), |i, k| eigen.U()[(i, along[k])] / values[along[k]].sqrt());
    Ok(scaled * directions)
}
