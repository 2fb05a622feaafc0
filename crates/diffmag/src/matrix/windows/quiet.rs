//! η in quiet and in disturbed times.

use std::ops::Range;

use common::{Axis, MatrixOfTimes, QuietDisturbed};
use faer::Mat;

use super::stretch::{self, Noise};
use crate::Error;
use crate::constancy::{self, Estimate};
use crate::regression::AxisFit;
use joined::Pair;

/// Stretches as long as those of the index K, s.
const STRETCH_S: f64 = 10_800.0;
const LEAST_SAMPLES: usize = 30;
/// A stretch holds at least so many of the shortest periods that the matrix rests on: twice as many numbers
/// as η and a line have.
const PERIODS: f64 = 4.0;
/// There are at least this many stretches, if need be shorter ones.
const LEAST_STRETCHES: usize = 16;
const QUIET: f64 = 0.5;
const DISTURBED: f64 = 0.25;
/// Less activity than this, disturbed over quiet, is no contrast.
const CONTRAST: f64 = 2.0;

/// Ranks stretches by the rms of the reference's first differences, and holds η of the upper quarter against
/// that of the lower half: from variations within stretches, each with a level and a straight drift of its
/// own. None where the recording is too short to be divided.
pub fn quiet_disturbed(
    pair: &Pair,
    fits: &[AxisFit; 3],
    noise: &Noise<'_>,
) -> Result<Option<QuietDisturbed>, Error> {
    let rows = pair.whole.len();
    let shortest = (PERIODS / noise.highest_hz() / pair.step_s).ceil() as usize;
    let samples =
        ((STRETCH_S / pair.step_s) as usize).min(rows / LEAST_STRETCHES).max(LEAST_SAMPLES).max(shortest);
    let mut ranked: Vec<(f64, Range<usize>)> = (0..rows / samples)
        .map(|i| i * samples..(i + 1) * samples)
        .filter(|rows| pair.whole[rows.clone()].iter().all(|whole| *whole))
        .map(|rows| (activity(pair, &rows), rows))
        .collect();
    if ranked.len() < LEAST_STRETCHES {
        return Ok(None);
    }
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    let count = ranked.len() as f64;
    let (quiet, rest) = ranked.split_at((QUIET * count) as usize);
    let disturbed = &rest[rest.len() - (DISTURBED * count) as usize..];
    let (calm, lively) = (rms(quiet), rms(disturbed));
    let mut found = QuietDisturbed {
        stretch_s: samples as f64 * pair.step_s,
        stretches: ranked.len(),
        activity_ratio: lively / calm,
        ..QuietDisturbed::default()
    };
    if found.activity_ratio < CONTRAST {
        return Ok(Some(found));
    }
    let (mut columns, mut tests) = (Vec::new(), Vec::new());
    for axis in Axis::ALL {
        let pooled = |times: &[(f64, Range<usize>)]| -> Result<Estimate, Error> {
            let density = |f: f64| noise.weighing(axis.index(), f);
            let all = times.iter().map(|(_, rows)| stretch::estimate(pair, fits, &density, axis, rows));
            // In a stretch in which a component does not vary there is nothing to be found.
            stretch::pooled(&all.filter_map(Result::ok).collect::<Vec<_>>())
        };
        let both = [pooled(quiet)?, pooled(disturbed)?];
        tests.push(constancy::fit(&both, 3, |_| Mat::identity(3, 3))?.chi_squared(0.0));
        columns.push(both);
    }
    found.one_matrix = Some(constancy::together([tests[0], tests[1], tests[2]], &noise.correlation_squared));
    let of = |which: usize, times: &[(f64, Range<usize>)], activity_nt: f64| MatrixOfTimes {
        times_s: joined(pair, times),
        activity_nt,
        estimate: stretch::documented(std::array::from_fn(|j| &columns[j][which])),
    };
    found.quiet = Some(of(0, quiet, calm));
    found.disturbed = Some(of(1, disturbed, lively));
    Ok(Some(found))
}

/// Rms of the reference's first differences, all axes together, nT.
fn activity(pair: &Pair, rows: &Range<usize>) -> f64 {
    let changes = pair.reference.iter().flat_map(|column| column[rows.clone()].windows(2));
    let squares: f64 = changes.map(|both| (both[1] - both[0]).powi(2)).sum();
    (squares / (rows.len() - 1) as f64).sqrt()
}

fn rms(times: &[(f64, Range<usize>)]) -> f64 {
    (times.iter().map(|(activity, _)| activity * activity).sum::<f64>() / times.len() as f64).sqrt()
}

/// From and to, s, neighbours joined.
fn joined(pair: &Pair, times: &[(f64, Range<usize>)]) -> Vec<[f64; 2]> {
    let mut rows: Vec<Range<usize>> = times.iter().map(|(_, rows)| rows.clone()).collect();
    rows.sort_by_key(|rows| rows.start);
    let mut joined: Vec<Range<usize>> = Vec::new();
    for next in rows {
        match joined.last_mut() {
            Some(last) if last.end == next.start => last.end = next.end,
            _ => joined.push(next),
        }
    }
    joined.iter().map(|rows| [pair.time_s(rows.start), pair.time_s(rows.end - 1)]).collect()
}
