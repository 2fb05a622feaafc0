//! A pair as a problem for the engine `explain`: the test instrument's readings beside the reference's.
//!
//! A clock that is late by δ reads the field of δ earlier: the difference holds −δ dB/dt.

use estimate::stats;
use explain::{Covariate, Fit, Problem, smoothed, thinned};
use faer::Mat;
use joined::Pair;

use crate::courses::Sensors;
use crate::events::Events;
use crate::look::{Shift, seen_rate, turned};

/// The reference without what is faster than so many steps is fitted besides: its noise, and filters, make the
/// answer to the field another one at short periods, without delay. So many rows for each step are needed.
const SMOOTH_STEPS: [f64; 3] = [4.0, 32.0, 256.0];
const SMOOTH_ROWS: f64 = 64.0;
/// The answer at short periods is that at long ones within this standard deviation, nT/nT.
pub const ALIKE: f64 = 1.0;

/// Of more rows so many are weighed, in so many blocks that are spread over all: a day of seconds whole, a tenth of a
/// month.
const MOST: usize = 1 << 18;
const BLOCKS: usize = 64;

/// Rows in which both instruments read and nothing is `disturbed`, with the reference at the test instrument's
/// moments, this one's times being late by `shift`.
pub fn problem(
    recorded: &Pair,
    covariates: &[Covariate],
    (disturbed, shift): (&Events, Shift),
) -> (Problem, Sensors, Vec<usize>) {
    let pair = disturbed.aligned(recorded, shift);
    let rows: Vec<usize> = (0..pair.whole.len()).filter(|row| pair.whole[*row]).collect();
    let at = |column: &[f64]| -> Vec<f64> { rows.iter().map(|row| column[*row]).collect() };
    let base: Vec<Vec<f64>> = pair.reference.iter().map(|column| at(column)).collect();
    let channels: Vec<Vec<f64>> = pair.test.iter().map(|column| at(column)).collect();
    let late = |column| at(&seen_rate(&pair, column)).iter().map(|rate| -rate).collect();
    let late: [Vec<f64>; 3] = pair.reference.each_ref().map(|column| late(column));
    let answers: Vec<[f64; 3]> = channels.iter().map(|channel| answer(&base, channel)).collect();
    let rates: Vec<Vec<f64>> = answers.iter().map(|eta| turned(&late, eta)).collect();
    let sensors = Sensors::of(&base, &late, &answers);
    let time_s = at(&pair.times_s());
    let fast = fast(&time_s, &base, pair.step_s);
    let white = channels.iter().map(|channel| white(&base, channel)).fold(f64::INFINITY, f64::min).sqrt();
    let kept = thinned(rows.len(), MOST, BLOCKS);
    let problem = Problem {
        time_s,
        channels,
        known: [0.0; 3].into_iter().chain(fast.iter().map(|_| white / ALIKE)).collect(),
        base: base.into_iter().chain(fast).collect(),
        noisy: 3,
        covariates: covariates.to_vec(),
        rates,
        ..Problem::default()
    };
    if kept.len() == rows.len() {
        return (problem, sensors, rows);
    }
    (problem.at(&kept), sensors.at(&kept), kept.into_iter().map(|row| rows[row]).collect())
}

/// What is faster than some steps in each column, by a high-pass filter that is applied twice, so that neither slope nor
/// curvature of the field is left.
fn fast(time_s: &[f64], columns: &[Vec<f64>], step_s: f64) -> Vec<Vec<f64>> {
    let steps = SMOOTH_STEPS.into_iter().filter(|steps| time_s.len() as f64 >= SMOOTH_ROWS * steps);
    let of = |(column, steps): (&Vec<f64>, f64)| {
        let late_s = steps * step_s;
        let faster = |column: &[f64]| -> Vec<f64> {
            let slow = smoothed(time_s, column, late_s);
            column.iter().zip(slow).map(|(all, slow)| all - slow).collect()
        };
        faster(&faster(column))
    };
    steps.flat_map(|steps| columns.iter().map(move |column| (column, steps))).map(of).collect()
}

/// The sums of squares that plain least squares on the reference leave of each channel.
pub fn squares(problem: &Problem) -> Vec<f64> {
    let of = |channel: &Vec<f64>| {
        let all: Vec<&[f64]> = problem.base.iter().take(3).chain([channel]).map(Vec::as_slice).collect();
        regressed(&all).left
    };
    problem.channels.iter().map(of).collect()
}

/// Plain least squares of the last column on the others and a level.
fn regressed(all: &[&[f64]]) -> Fit {
    let means: Vec<f64> = all.iter().map(|column| stats::mean(column)).collect();
    let count = all.len();
    let gram = Mat::from_fn(count, count, |i, j| {
        all[i].iter().zip(all[j]).map(|(a, b)| (a - means[i]) * (b - means[j])).sum::<f64>()
    });
    Fit::of(&gram, count - 1, &(0..count - 1).collect::<Vec<_>>())
}

/// How a channel answers to each component of the reference, as plain least squares have it.
fn answer(base: &[Vec<f64>], channel: &[f64]) -> [f64; 3] {
    let all: Vec<&[f64]> = base.iter().map(Vec::as_slice).chain([channel]).collect();
    let fit = regressed(&all);
    std::array::from_fn(|component| fit.coefficient(component))
}

/// White variance of what a regression of changes on changes leaves.
fn white(reference: &[Vec<f64>], test: &[f64]) -> f64 {
    let changes = |column: &[f64]| -> Vec<f64> { column.windows(2).map(|pair| pair[1] - pair[0]).collect() };
    let all: Vec<Vec<f64>> = reference.iter().map(|column| changes(column)).chain([changes(test)]).collect();
    let all: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
    let left = regressed(&all).left;
    (0.5 * left / test.len() as f64).max(f64::MIN_POSITIVE)
}
