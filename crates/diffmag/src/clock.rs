//! The clock of the test instrument against the reference's.

use common::{ClockDifference, Quantity};
use estimate::resample::{PASSBAND, resample};
use estimate::{events, lag, spectral, stats};
use faer::Mat;

use crate::difference::Noise;
use crate::drift::days;
use crate::regression::rest;
use crate::series::Pair;
use crate::{Error, TOLD_BELOW};
use std::ops::Range;

/// Rounds of fitting the noise and the regression under it.
const ROUNDS: usize = 2;
/// Time constants of the drifts that a look takes off, as shares of the length; fewer rows than these have none.
const DRIFTS: [f64; 4] = [0.5, 0.15, 0.045, 0.0135];
const LEAST_FOR_DRIFTS: usize = 512;
/// Columns of a look before the reference's: offset and rate.
const CLOCK: usize = 2;
/// Samples between a row and the places whose difference gives the slope.
const BESIDE: f64 = 0.1;
/// Largest offset that is searched, as a share of the recording's length.
const REACH: f64 = 0.1;
/// Changes from row to row that are so many times their median count as much: a spike of one instrument has no lag.
const LARGEST_CHANGE: f64 = 8.0;
/// A lag must explain more than none does by this χ², and leave so much less.
pub const GAIN: f64 = 50.0;

/// How late the test instrument's times are: offset + rate × time from the middle of a segment between jumps of the times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shift {
    /// In the middle of each segment, beside what the segment has of its own, s.
    pub offset_s: f64,
    /// s/s.
    pub rate: f64,
}

impl Shift {
    /// At a time from the middle of a segment on the test instrument's clock, s.
    pub fn at(&self, from_middle_s: f64) -> f64 {
        self.offset_s + self.rate * from_middle_s
    }

    /// None.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// The instrument whose readings are moved in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moved {
    /// The reference, to the moments at which the test instrument read: nothing happens to the test instrument's readings.
    Reference,
    /// The test instrument, to the reference's clock.
    Test,
}

/// How late the test instrument's times are in a row, s.
pub fn late_s(pair: &Pair, shift: Shift, row: usize) -> f64 {
    pair.segment(row).late_s + shift.at(pair.since_middle_of_segment_s(row))
}

/// Whether any row is to be moved.
pub fn moves(pair: &Pair, shift: Shift) -> bool {
    !shift.is_none() || pair.segments.iter().any(|segment| segment.late_s != 0.0)
}

/// The pair with both instruments at the same moments if the test instrument's times are late by `shift` and what each segment has of its own.
///
/// Each segment is read from its own rows alone: across a jump an instrument's rows are no even series.
pub fn aligned(pair: &Pair, shift: Shift, moved: Moved) -> Pair {
    let mut pair = pair.clone();
    if !moves(&pair, shift) {
        return pair;
    }
    let places: Vec<f64> = (0..pair.whole.len())
        .map(|row| {
            let late = late_s(&pair, shift, row);
            let by = match moved {
                Moved::Reference => -late,
                Moved::Test => late + shift.rate * late,
            };
            row as f64 + by / pair.step_s
        })
        .collect();
    if moved == Moved::Test {
        for axis in 0..3 {
            for number in 0..pair.steps[axis].len() {
                let row = pair.steps[axis][number];
                let late = late_s(&pair, shift, row) / pair.step_s;
                pair.steps[axis][number] =
                    (row as f64 - late).round().clamp(1.0, places.len() as f64 - 1.0) as usize;
            }
        }
    }
    let segments: Vec<Range<usize>> = pair.segments.iter().map(|segment| segment.rows.clone()).collect();
    let columns = match moved {
        Moved::Reference => &mut pair.reference,
        Moved::Test => &mut pair.test,
    };
    for column in columns.iter_mut() {
        for (value, _) in column.iter_mut().zip(&pair.whole).filter(|(_, whole)| !**whole) {
            *value = f64::NAN;
        }
    }
    for rows in segments {
        let own = columns.each_ref().map(|column| &column[rows.clone()]);
        let places: Vec<f64> = places[rows.clone()].iter().map(|place| place - rows.start as f64).collect();
        let read = resample(&own, &places, 1.0);
        for (column, read) in columns.iter_mut().zip(read.columns) {
            column[rows.clone()].copy_from_slice(&read);
        }
    }
    let whole = |row: usize| columns.iter().all(|column| column[row].is_finite());
    let whole: Vec<bool> = (0..places.len()).map(|row| pair.whole[row] && whole(row)).collect();
    pair.whole = whole;
    pair.segments.iter_mut().for_each(|segment| segment.late_s = 0.0);
    pair.highest_hz = Some(PASSBAND * 0.5 / pair.step_s);
    pair.bridge();
    pair
}

/// A fit of one axis with the clock's columns in it.
pub struct LookAxis {
    /// What the reference's x, y, z give.
    pub eta: [f64; 3],
    /// Noise of what is left.
    pub noise: Noise,
    /// Coefficients of the clock's columns, of the reference, of drifts and of steps.
    coefficients: Vec<f64>,
    turned_by: [f64; 3],
}

/// What the clock shows in, and what it shows beside.
pub struct Parts {
    /// −dB/dt of the field along the axis; nothing in rows that are not whole.
    pub late: Vec<f64>,
    /// The field along the axis.
    pub turned: Vec<f64>,
    /// The test instrument's readings less what the reference, drifts and steps give.
    pub left: Vec<f64>,
}

/// A fit of the three axes, and the clock that it shows.
pub struct Look {
    /// The axes.
    pub axes: [LookAxis; 3],
    /// What is left of the clocks' difference; None where nothing says it.
    pub clock: Option<ClockDifference>,
}

/// Fits each axis with the reference, a straight drift and the clock's difference.
///
/// A clock that is late by δ reads the field of δ earlier: d holds −δ dB/dt, the same δ on all axes; with a rate it grows in time. So
/// the columns of an axis are −dB/dt and −t dB/dt of the field along it, Rη; the axes' answers are put together by their information.
pub fn look(pair: &Pair) -> Result<Look, Error> {
    let drifts = drifts(pair);
    let (mut information, mut right) = ([[0.0; 2]; 2], [0.0; 2]);
    let mut one = |axis: usize| -> Result<LookAxis, Error> {
        let test = &pair.test[axis];
        let mut base: Vec<Vec<f64>> = pair.reference.to_vec();
        base.extend(drifts.iter().cloned());
        let plain = spectral::regress(&base, test, pair.step_s, &|_| 1.0)?;
        let mut eta = std::array::from_fn(|i| plain.least_squares[i]);
        let mut noise = Noise::seen(&rest(&base, test, &plain.least_squares), pair)?;
        let under = spectral::regress(&base, test, pair.step_s, &|f| noise.density(f))?;
        // Where the instruments do not answer alike at all frequencies, what is strong decides.
        let agree = spectral::agreement_p(
            (&under.least_squares[..3], &under.covariance),
            (&under.weighted[..3], &under.weighted_covariance),
        )?;
        let plain_only = agree < TOLD_BELOW;
        let mut turned_by = eta;
        let mut coefficients = Vec::new();
        for round in 0..ROUNDS {
            turned_by = eta;
            let mut columns = seen(clock_columns(pair, &turned_by), &pair.whole);
            columns.extend(base.iter().cloned());
            let mut fit = spectral::regress(&columns, test, pair.step_s, &|f| noise.density(f))?;
            if plain_only {
                (fit.weighted, fit.weighted_covariance) = (fit.least_squares.clone(), fit.covariance.clone());
            }
            eta = std::array::from_fn(|i| fit.weighted[CLOCK + i]);
            if round + 1 == ROUNDS {
                add(&mut information, &mut right, &fit);
            }
            noise = Noise::seen(&rest(&columns, test, &fit.weighted), pair)?;
            coefficients = fit.weighted.clone();
        }
        Ok(LookAxis { eta, noise, coefficients, turned_by })
    };
    let axes = [one(0)?, one(1)?, one(2)?];
    Ok(Look { axes, clock: solved(information, right) })
}

impl Look {
    /// What is left of an axis of another pair on the same grid: steps that were taken off before the look are in it. The clock shows
    /// in the slope of the field, that of `calm`: what only the reference read is no field.
    pub fn left(&self, pair: &Pair, calm: &Pair, axis: usize) -> Vec<f64> {
        let mut columns = clock_columns(calm, &self.axes[axis].turned_by);
        columns.extend(self.others(pair));
        rest(&columns, &pair.test[axis], &self.axes[axis].coefficients)
    }

    /// Gives the test instrument its most likely readings where rows are not whole: what the reference says, and what is left before
    /// and after.
    pub fn complete(&self, pair: &mut Pair) -> Result<(), Error> {
        let missing: Vec<bool> = pair.whole.iter().map(|whole| !whole).collect();
        if !missing.contains(&true) {
            return Ok(());
        }
        for (axis, of) in self.axes.iter().enumerate() {
            let mut columns = seen(clock_columns(pair, &of.turned_by), &pair.whole);
            columns.extend(self.others(pair));
            let left = rest(&columns, &pair.test[axis], &of.coefficients);
            let filled = events::fill(&left, &missing, pair.step_s, &|f| of.noise.density(f))?;
            for (row, value) in pair.test[axis].iter_mut().enumerate().filter(|(row, _)| missing[*row]) {
                *value += filled[row] - left[row];
            }
        }
        Ok(())
    }

    /// Of an axis: −dB/dt of the field along it, that field, and what the test instrument reads beside it and drifts.
    pub fn parts(&self, pair: &Pair, axis: usize) -> Parts {
        let of = &self.axes[axis];
        let [late, _] = <[Vec<f64>; 2]>::try_from(seen(clock_columns(pair, &of.turned_by), &pair.whole))
            .unwrap_or_default();
        let turned = turned(pair, &of.turned_by);
        let left = rest(&self.others(pair), &pair.test[axis], &of.coefficients[CLOCK..]);
        Parts { late, turned, left }
    }

    /// Columns after the clock's, steps left out.
    fn others(&self, pair: &Pair) -> Vec<Vec<f64>> {
        pair.reference.iter().cloned().chain(drifts(pair)).collect()
    }

    /// What is left of an axis, limited.
    fn limited_left(&self, pair: &Pair, axis: usize, whole: &[bool]) -> Vec<f64> {
        let left = self.left(pair, pair, axis);
        limited(&left, whole, usual(&left, whole))
    }

    /// How much less, in χ² under this fit's noise, another fit leaves of the same rows moved in time. Here only what is left is limited: a
    /// sudden change of the field that was limited in both instruments may seem to lag where it does not.
    pub fn gain(&self, pair: &Pair, moved: &Look, moved_pair: &Pair) -> Result<f64, Error> {
        let whole: Vec<bool> = pair.whole.iter().zip(&moved_pair.whole).map(|(a, b)| *a && *b).collect();
        let mut gain = 0.0;
        for axis in 0..self.axes.len() {
            let left = [self.limited_left(pair, axis, &whole), moved.limited_left(moved_pair, axis, &whole)];
            let noise = Noise::seen(&left[0], pair)?;
            let [here, there] = left.map(|left| {
                // It explains all of itself.
                lag::explained(std::slice::from_ref(&left), &left, pair.step_s, &|f| noise.density(f), 0)
            });
            gain += here?[0] - there?[0];
        }
        Ok(gain)
    }

    /// An offset of at least one sample, where the two instruments' changes match far better with it: the lag of the largest likelihood, s.
    pub fn coarse_offset_s(&self, pair: &Pair) -> Result<Option<f64>, Error> {
        let reach = (REACH * pair.whole.len() as f64) as usize;
        let mut gains = vec![0.0; 2 * reach + 1];
        // One limit for all: a change of the field that is cut at another height in the other instrument would seem to come at another time.
        let columns = pair.reference.iter().chain(&pair.test);
        let most = columns.map(|column| usual(column, &pair.whole)).fold(0.0, f64::max);
        let reference = pair.reference.each_ref().map(|column| limited(column, &pair.whole, most));
        for (axis, test) in pair.test.iter().enumerate() {
            // A sudden change at the wrong time would be most of the noise.
            let noise = Noise::seen(&self.limited_left(pair, axis, &pair.whole), pair)?;
            let density = |f: f64| noise.density(f);
            let of_axis =
                lag::explained(&reference, &limited(test, &pair.whole, most), pair.step_s, &density, reach)?;
            gains.iter_mut().zip(of_axis).for_each(|(sum, gain)| *sum += gain);
        }
        let best =
            (0..gains.len()).fold(reach, |best, lag| if gains[lag] > gains[best] { lag } else { best });
        let found = gains[best] - gains[reach] > GAIN;
        Ok(found.then_some((best as f64 - reach as f64) * pair.step_s))
    }
}

/// A straight drift, and exponential ones enough to take off any that comes to rest: else its beginning would be taken for steps.
fn drifts(pair: &Pair) -> Vec<Vec<f64>> {
    let rows = pair.whole.len();
    let exponential = |share: &f64| -> Vec<f64> {
        (0..rows).map(|row| (-(row as f64) / (share * rows as f64)).exp()).collect()
    };
    let shares: &[f64] = if rows < LEAST_FOR_DRIFTS { &[] } else { &DRIFTS };
    std::iter::once(days(pair)).chain(shares.iter().map(exponential)).collect()
}

/// The field Rη along an axis.
fn turned(pair: &Pair, eta: &[f64; 3]) -> Vec<f64> {
    (0..pair.whole.len()).map(|row| (0..3).map(|i| eta[i] * pair.reference[i][row]).sum()).collect()
}

/// −dB/dt of the field Rη along an axis, and that times the time from the middle of the segment in 10⁶ s.
fn clock_columns(pair: &Pair, eta: &[f64; 3]) -> Vec<Vec<f64>> {
    let late: Vec<f64> = slope(&turned(pair, eta), pair.step_s).iter().map(|rate| -rate).collect();
    let fast = late
        .iter()
        .enumerate()
        .map(|(row, late)| late * pair.since_middle_of_segment_s(row) * 1e-6)
        .collect();
    vec![late, fast]
}

/// Columns of the clock with nothing in rows that are not whole: readings that were filled in say nothing of it, and a reading filled in with a
/// wrong clock would confirm that one.
fn seen(mut columns: Vec<Vec<f64>>, whole: &[bool]) -> Vec<Vec<f64>> {
    for column in &mut columns {
        column.iter_mut().zip(whole).filter(|(_, whole)| !**whole).for_each(|(value, _)| *value = 0.0);
    }
    columns
}

/// How much a series may change from row to row and be taken as it is.
fn usual(values: &[f64], whole: &[bool]) -> f64 {
    let known = (1..values.len()).filter(|row| whole[row - 1] && whole[*row]);
    LARGEST_CHANGE
        * stats::median(&known.map(|row| (values[row] - values[row - 1]).abs()).collect::<Vec<_>>())
}

/// A series whose changes are limited: spikes and steps are still in it when a lag is looked for. Beside rows that are not whole it does not
/// change.
fn limited(values: &[f64], whole: &[bool], most: f64) -> Vec<f64> {
    if most == 0.0 {
        return values.to_vec();
    }
    let mut level = 0.0;
    let sums = (1..values.len()).map(|row| {
        if whole[row - 1] && whole[row] {
            level += (values[row] - values[row - 1]).clamp(-most, most);
        }
        level
    });
    std::iter::once(0.0).chain(sums).collect()
}

/// Adds one axis' knowledge of offset and rate, all its other unknowns free.
fn add(information: &mut [[f64; 2]; 2], right: &mut [f64; 2], fit: &spectral::SpectralFit) {
    let block = Mat::from_fn(2, 2, |i, j| fit.weighted_covariance[(i, j)]);
    let determinant = block[(0, 0)] * block[(1, 1)] - block[(0, 1)] * block[(1, 0)];
    let inverse = [
        [block[(1, 1)] / determinant, -block[(0, 1)] / determinant],
        [-block[(1, 0)] / determinant, block[(0, 0)] / determinant],
    ];
    for i in 0..2 {
        for j in 0..2 {
            information[i][j] += inverse[i][j];
            right[i] += inverse[i][j] * fit.weighted[j];
        }
    }
}

fn solved([[a, b], [c, d]]: [[f64; 2]; 2], right: [f64; 2]) -> Option<ClockDifference> {
    let determinant = a * d - b * c;
    if determinant.is_nan() || determinant <= 0.0 {
        return None;
    }
    let offset = (d * right[0] - b * right[1]) / determinant;
    let rate = (a * right[1] - c * right[0]) / determinant;
    Some(ClockDifference {
        offset_s: Quantity::new(offset, (d / determinant).sqrt()),
        rate_ppm: Quantity::new(rate, (a / determinant).sqrt()),
        ..ClockDifference::default()
    })
}

/// dB/dt by the difference over a fifth of a step of the band-limited interpolation, nT/s: within 2 % up to half the sampling rate.
/// Differences of whole steps would fall short by more than half where the field says most about the clock.
fn slope(values: &[f64], step_s: f64) -> Vec<f64> {
    let beside = |by: f64| {
        let places: Vec<f64> = (0..values.len()).map(|row| row as f64 + by).collect();
        resample(&[values], &places, 1.0).columns.swap_remove(0)
    };
    let rate =
        beside(BESIDE).into_iter().zip(beside(-BESIDE)).map(|(b, a)| (b - a) / (2.0 * BESIDE * step_s));
    // Beyond the ends nothing is known.
    rate.map(|rate| if rate.is_finite() { rate } else { 0.0 }).collect()
}
