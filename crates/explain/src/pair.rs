//! Two instruments side by side, and their clocks: three components are held against three, or a magnitude
//! against them.
//!
//! A clock that is late by δ reads the field of δ earlier: the difference holds −δ dB/dt. Noise of the reference
//! is in the rate as well and makes its coefficient too small, though not wrong in sign: so the reference is
//! moved until nothing is left of it, and how the coefficient follows the move gives the uncertainty.

use common::Quantity;
use estimate::resample::resample;
use estimate::{Error, lag, stats};

use crate::amplitude::{Amplitude, fit};
use crate::explained::{Explained, explain};
use crate::fit::Fit;
use crate::form::{Form, smoothed};
use crate::problem::{Cause, Covariate, Problem};
use crate::search::AGAINST;

/// What the reference is moved by to either side for its rate, in steps.
const ASIDE: f64 = 0.2;
/// Fewer whole rows explain nothing.
pub const LEAST: usize = 32;
/// Rounds of moving the reference; the clocks agree when the next move is less than this share of its
/// uncertainty.
const ROUNDS: usize = 8;
const SETTLED: f64 = 0.1;
/// Largest offset that is searched, as a share of the length, and in rows.
const REACH: f64 = 0.1;
const MOST_ROWS: usize = 4_096;
/// A lag of whole rows must explain more than none by this χ².
const GAIN: f64 = 50.0;
/// The reference without what is faster than so many steps is fitted besides: its noise, and filters, make the
/// answer to the field another one at short periods, without delay. So many rows for each step are needed.
const SMOOTH_STEPS: [f64; 3] = [4.0, 32.0, 256.0];
const SMOOTH_ROWS: f64 = 64.0;
/// The answer at short periods is that at long ones within this standard deviation, nT/nT.
const ALIKE: f64 = 1.0;
/// Changes from row to row that are so many times their median count as much: a spike of one instrument has no
/// lag.
const LARGEST_CHANGE: f64 = 8.0;

/// Readings of a reference and a test instrument on one even grid.
#[derive(Clone, Debug)]
pub struct Pair {
    /// Time of the first row, s.
    pub first_s: f64,
    /// From one row to the next, s.
    pub step_s: f64,
    /// The reference; rows that are not whole stand on straight lines.
    pub reference: [Vec<f64>; 3],
    /// What is held against it, in the same way.
    pub test: Vec<Vec<f64>>,
    /// Rows in which neither misses a reading.
    pub whole: Vec<bool>,
    /// What was recorded beside.
    pub covariates: Vec<Covariate>,
}

/// How late the test instrument's clock is.
#[derive(Clone, Debug)]
pub struct Clock {
    /// In the middle of the recording, s.
    pub offset_s: Quantity,
    /// How fast that grows, s/s; absent where nothing shows it.
    pub rate: Option<Quantity>,
    /// ln of the odds against equal clocks.
    pub gain: f64,
}

impl Clock {
    /// Whether offset or rate stand by themselves: against the same odds as other names.
    fn differs(&self, problem: &Problem) -> bool {
        let odds = (problem.rows() as f64).ln_1p() + 2.0 * (AGAINST + (problem.causes().len() as f64).ln());
        let stands = |of: &Quantity| of.std().is_some_and(|std| (of.value() / std).powi(2) > odds);
        stands(&self.offset_s) || self.rate.as_ref().is_some_and(stands)
    }
}

/// What explains a pair.
pub struct OfPair {
    /// With the reference at the test instrument's moments. Its rows are those of `rows`.
    pub explained: Explained,
    /// The clock, where it differs.
    pub clock: Option<Clock>,
    /// The rows of the pair that were explained.
    pub rows: Vec<usize>,
    /// The problem they make.
    pub problem: Problem,
    /// Rms of what plain least squares leave of each channel with the clocks as they were recorded.
    pub unmoved: Vec<f64>,
}

/// How late the test instrument is, as far as it is known.
#[derive(Clone, Copy, Default)]
struct Late {
    offset_s: f64,
    rate: f64,
}

/// Explains a pair; `told` hears what is being done.
///
/// # Errors
///
/// Fewer whole rows than a fit needs.
pub fn pair(pair: &Pair, told: &dyn Fn(&str)) -> Result<OfPair, Error> {
    let mut late = Late::default();
    let (mut problem, mut rows) = pair.problem(late);
    if rows.len() < LEAST {
        return Err(Error::TooFew { found: rows.len(), unknowns: LEAST });
    }
    let unmoved: Vec<f64> =
        squares(&problem).iter().map(|left| (left / problem.rows() as f64).sqrt()).collect();
    told("comparing the clocks");
    let whole = pair.coarse_s(&problem, &rows)?;
    let whole = whole.filter(|offset_s| {
        // Where the field is nearly periodic, another lag may match the changes and not the field.
        let moved = pair.problem(Late { offset_s: *offset_s, rate: 0.0 });
        let better = left(&problem) - left(&moved.0);
        if better > GAIN {
            late.offset_s = *offset_s;
            (problem, rows) = moved;
        }
        better > GAIN
    });
    let mut explained = explain(&problem, told)?;
    let clock_of = |explained: &Explained| explained.causes.iter().position(|one| one.cause == Cause::Clock);
    let mut gain = whole.map_or(0.0, |_| GAIN);
    if let Some(place) = clock_of(&explained) {
        gain = gain.max(explained.gains[place]);
    }
    if gain == 0.0 {
        return Ok(OfPair { explained, clock: None, rows, problem, unmoved });
    }
    told("moving the reference to the test instrument's moments");
    let named = |explained: &Explained| -> Vec<(Cause, Form)> {
        let others = explained.causes.iter().filter(|one| one.cause != Cause::Clock);
        others.map(|one| (one.cause, one.form)).collect()
    };
    let rated = clock_of(&explained).is_some_and(|place| explained.causes[place].form.bent);
    let others = named(&explained);
    let start = late;
    let (mut follows, mut left) = (1.0, clock(&problem, &explained, &others, rated)?);
    for _ in 0..ROUNDS {
        let by = left[0].value() / follows;
        let settled = by.abs() <= SETTLED * left[0].std().unwrap_or(f64::INFINITY) / follows;
        if settled {
            break;
        }
        let was = left[0].value();
        late.offset_s += by;
        late.rate += left.get(1).map_or(0.0, |rate| rate.value() / follows);
        (problem, rows) = pair.problem(late);
        left = clock(&problem, &explained, &others, rated)?;
        follows = ((was - left[0].value()) / by).clamp(0.1, 1.5);
    }
    if late.offset_s != start.offset_s || late.rate != start.rate {
        explained = explain(&problem, told)?;
    }
    let over = |moved: f64, left: &Quantity| {
        Quantity::new(moved + left.value() / follows, left.std().unwrap_or(0.0) / follows)
    };
    let clock = Clock {
        offset_s: over(late.offset_s, &left[0]),
        rate: left.get(1).map(|rate| over(late.rate, rate)),
        gain,
    };
    if !clock.differs(&problem) {
        (problem, rows) = pair.problem(Late::default());
        problem.rates.clear();
        explained = explain(&problem, told)?;
        return Ok(OfPair { explained, clock: None, rows, problem, unmoved });
    }
    explained.without(Cause::Clock);
    Ok(OfPair { explained, clock: Some(clock), rows, problem, unmoved })
}

/// What is left of the clock's offset, and of its rate, beside the causes that were named.
fn clock(
    problem: &Problem,
    explained: &Explained,
    others: &[(Cause, Form)],
    rated: bool,
) -> Result<Vec<Quantity>, Error> {
    let kept: Vec<usize> =
        (0..problem.rows().min(explained.off.len())).filter(|row| !explained.off[*row]).collect();
    let mut part = problem.at(&kept);
    part.steps = explained.steps.iter().map(|step| kept.partition_point(|row| *row < step.row)).collect();
    part.steps.retain(|step| *step > 0 && *step < kept.len());
    let with: Vec<(Cause, Form)> =
        others.iter().copied().chain([(Cause::Clock, Form { bent: rated, ..Form::default() })]).collect();
    let fitted = fit(&part, &with, &explained.noises)?;
    Ok(fitted.amplitudes.last().map(Amplitude::first).unwrap_or_default())
}

impl Pair {
    /// With the reference at the moments of the test instrument, and the rows that are whole then.
    fn problem(&self, late: Late) -> (Problem, Vec<usize>) {
        let moved = self.reference_at(late, 0.0);
        let aside = [ASIDE, -ASIDE].map(|by| self.reference_at(late, by));
        let ready = |row: &usize| self.whole[*row] && moved.iter().all(|column| column[*row].is_finite());
        let rows: Vec<usize> = (0..self.whole.len()).filter(ready).collect();
        let at = |column: &[f64]| -> Vec<f64> { rows.iter().map(|row| column[*row]).collect() };
        let base: Vec<Vec<f64>> = moved.iter().map(|column| at(column)).collect();
        let channels: Vec<Vec<f64>> = self.test.iter().map(|column| at(column)).collect();
        let slope = |axis: usize| -> Vec<f64> {
            let rise =
                |row: &usize| (aside[0][axis][*row] - aside[1][axis][*row]) / (2.0 * ASIDE * self.step_s);
            // Beside a gap nothing is known of the rate.
            rows.iter().map(rise).map(|slope| if slope.is_finite() { slope } else { 0.0 }).collect()
        };
        let slopes = [0, 1, 2].map(slope);
        let rates = channels.iter().map(|channel| rate(&base, channel, &slopes)).collect();
        let time_s: Vec<f64> = rows.iter().map(|row| self.first_s + *row as f64 * self.step_s).collect();
        let fast = self.fast(&time_s, &base);
        let white = channels.iter().map(|channel| white(&base, channel)).fold(f64::INFINITY, f64::min).sqrt();
        let known = [0.0; 3].into_iter().chain(fast.iter().map(|_| white / ALIKE)).collect();
        let base = base.into_iter().chain(fast).collect();
        let covariates = self.covariates.clone();
        (Problem { time_s, channels, base, known, noisy: 3, covariates, rates, ..Problem::default() }, rows)
    }

    /// What is faster than some steps in each column.
    fn fast(&self, time_s: &[f64], columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let steps = SMOOTH_STEPS.into_iter().filter(|steps| time_s.len() as f64 >= SMOOTH_ROWS * steps);
        let of = |(column, steps): (&Vec<f64>, f64)| {
            let slow = smoothed(time_s, column, steps * self.step_s);
            column.iter().zip(slow).map(|(all, slow)| all - slow).collect()
        };
        steps.flat_map(|steps| columns.iter().map(move |column| (column, steps))).map(of).collect()
    }

    /// The reference's readings of `late` before each row, and `aside` steps after that.
    fn reference_at(&self, late: Late, aside: f64) -> Vec<Vec<f64>> {
        if late.offset_s == 0.0 && late.rate == 0.0 && aside == 0.0 {
            return self.reference.to_vec();
        }
        let count = self.whole.len();
        let middle = 0.5 * (count as f64 - 1.0);
        let place = |row: usize| {
            row as f64 - (late.offset_s / self.step_s + late.rate * (row as f64 - middle)) + aside
        };
        let places: Vec<f64> = (0..count).map(place).collect();
        let own: Vec<Vec<f64>> = self
            .reference
            .iter()
            .map(|column| {
                column
                    .iter()
                    .zip(&self.whole)
                    .map(|(value, whole)| if *whole { *value } else { f64::NAN })
                    .collect()
            })
            .collect();
        resample(&own, &places, 1.0).columns
    }

    /// The lag of whole rows by which the test instrument's changes follow the reference's far better than
    /// without, s.
    fn coarse_s(&self, problem: &Problem, rows: &[usize]) -> Result<Option<f64>, Error> {
        let reach = ((REACH * rows.len() as f64) as usize).min(MOST_ROWS);
        if reach == 0 {
            return Ok(None);
        }
        let reference: Vec<Vec<f64>> = problem.base.iter().take(3).map(|column| limited(column)).collect();
        let mut gains = vec![0.0; 2 * reach + 1];
        for test in &problem.channels {
            let test = limited(test);
            let white = white(&reference, &test);
            let density = |f: f64| white * (1.0 + (0.02 / (f * self.step_s)).powi(2));
            let of = lag::explained(&reference, &test, self.step_s, &density, reach)?;
            gains.iter_mut().zip(of).for_each(|(sum, gain)| *sum += gain);
        }
        let best =
            (0..gains.len()).fold(reach, |best, lag| if gains[lag] > gains[best] { lag } else { best });
        let found = gains[best] - gains[reach] > GAIN;
        Ok(found.then_some((best as f64 - reach as f64) * self.step_s))
    }
}

/// n ln of the sums of squares that plain least squares on the reference leave of all channels.
fn left(problem: &Problem) -> f64 {
    let rows = problem.rows() as f64;
    rows * squares(problem).iter().map(|left| (left / rows).ln()).sum::<f64>()
}

/// The sums of squares that plain least squares on the reference leave of each channel.
fn squares(problem: &Problem) -> Vec<f64> {
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
    let gram = faer::Mat::from_fn(count, count, |i, j| {
        all[i].iter().zip(all[j]).map(|(a, b)| (a - means[i]) * (b - means[j])).sum::<f64>()
    });
    Fit::of(&gram, count - 1, &(0..count - 1).collect::<Vec<_>>())
}

/// −dB/dt of the field along a channel, as plain least squares have it.
fn rate(base: &[Vec<f64>], channel: &[f64], slopes: &[Vec<f64>; 3]) -> Vec<f64> {
    let all: Vec<&[f64]> = base.iter().map(Vec::as_slice).chain([channel]).collect();
    let fit = regressed(&all);
    let along = |row: usize| -> f64 { (0..3).map(|i| fit.coefficient(i) * slopes[i][row]).sum() };
    (0..channel.len()).map(|row| -along(row)).collect()
}

/// White variance of what a regression of changes on changes leaves.
fn white(reference: &[Vec<f64>], test: &[f64]) -> f64 {
    let changes = |column: &[f64]| -> Vec<f64> { column.windows(2).map(|pair| pair[1] - pair[0]).collect() };
    let all: Vec<Vec<f64>> = reference.iter().map(|column| changes(column)).chain([changes(test)]).collect();
    let all: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
    let left = regressed(&all).left;
    (0.5 * left / test.len() as f64).max(f64::MIN_POSITIVE)
}

/// A series whose changes are limited.
fn limited(values: &[f64]) -> Vec<f64> {
    let changes: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut sizes: Vec<f64> = changes.iter().map(|change| change.abs()).collect();
    let most = LARGEST_CHANGE * stats::median_of(&mut sizes);
    let mut level = 0.0;
    let sums = changes.iter().map(|change| {
        level += if most > 0.0 { change.clamp(-most, most) } else { *change };
        level
    });
    [0.0].into_iter().chain(sums).collect()
}
