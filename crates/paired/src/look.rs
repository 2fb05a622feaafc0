//! The clock of the test instrument against the reference's.

mod coarse;
mod columns;

use common::{ClockDifference, Quantity};
use estimate::events;
use estimate::resample::{PASSBAND, resample};
use estimate::spectral::{self, Transform, WeightedFit};
use faer::Mat;

use crate::noise::Noise;
use crate::residual::rest;
use crate::{Error, TOLD_BELOW, axes};
use columns::{beside, clock_columns, rate};
pub(crate) use columns::{seen_rate, turned};
use joined::Pair;
use std::borrow::Cow;
use std::ops::Range;

/// Rounds of fitting the noise and the regression under it.
const ROUNDS: usize = 2;
/// Columns of a look before the reference's: offset and rate.
const CLOCK: usize = 2;

/// How late the test instrument's times are: offset + rate × time from the middle of a segment between jumps
/// of the times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shift {
    /// In the middle of each segment, beside what the segment has of its own, s.
    pub offset_s: f64,
    /// s/s.
    pub rate: f64,
}

impl Shift {
    /// At a time from the middle of a segment on the test instrument's clock, s.
    fn at(&self, from_middle_s: f64) -> f64 {
        self.offset_s + self.rate * from_middle_s
    }

    pub(crate) fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// The instrument whose readings are moved in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moved {
    /// The reference, to the moments at which the test instrument read: nothing happens to the test
    /// instrument's readings.
    Reference,
    /// The test instrument, to the reference's clock.
    Test,
}

/// How late the test instrument's times are in a row, s.
pub(crate) fn late_s(pair: &Pair, shift: Shift, row: usize) -> f64 {
    pair.segment(row).late_s + shift.at(pair.since_middle_of_segment_s(row))
}

/// Whether any row is to be moved.
pub(crate) fn moves(pair: &Pair, shift: Shift) -> bool {
    !shift.is_none() || pair.segments.iter().any(|segment| segment.late_s != 0.0)
}

/// The pair with both instruments at the same moments if the test instrument's times are late by `shift` and
/// what each segment has of its own.
///
/// Each segment is read from its own rows alone: across a jump an instrument's rows are no even series.
pub fn aligned(mut pair: Pair, shift: Shift, moved: Moved) -> Pair {
    if !moves(&pair, shift) {
        return pair;
    }
    let place = |row: usize| {
        let late = late_s(&pair, shift, row);
        let by = if moved == Moved::Test { late + shift.rate * late } else { -late };
        row as f64 + by / pair.step_s
    };
    let places: Vec<f64> = (0..pair.whole.len()).map(place).collect();
    if moved == Moved::Test {
        let mut steps = std::mem::take(&mut pair.steps);
        for (row, _) in steps.iter_mut().flatten() {
            let late = late_s(&pair, shift, *row) / pair.step_s;
            *row = (*row as f64 - late).round().clamp(1.0, places.len() as f64 - 1.0) as usize;
        }
        pair.steps = steps;
    }
    let segments: Vec<Range<usize>> = pair.segments.iter().map(|segment| segment.rows.clone()).collect();
    let columns = match moved {
        Moved::Reference => pair.reference.as_mut_slice(),
        Moved::Test => pair.test.as_mut_slice(),
    };
    for column in columns.iter_mut().filter(|_| pair.whole.contains(&false)) {
        for (value, _) in column.iter_mut().zip(&pair.whole).filter(|(_, whole)| !**whole) {
            *value = f64::NAN;
        }
    }
    for rows in segments {
        let own: Vec<&[f64]> = columns.iter().map(|column| &column[rows.clone()]).collect();
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
pub(crate) struct LookAxis {
    /// What the reference's x, y, z give.
    pub eta: [f64; 3],
    /// Noise of what is left.
    pub noise: Noise,
    /// Coefficients of the clock's columns, of the reference, of drifts and of steps.
    coefficients: Vec<f64>,
    turned_by: [f64; 3],
}

/// A fit of all axes, and the clock that it shows.
pub(crate) struct Look {
    pub axes: Vec<LookAxis>,
    /// What is left of the clocks' difference; None where nothing says it.
    pub clock: Option<ClockDifference>,
}

/// Fits each axis with the reference, a straight drift and the clock's difference.
///
/// A clock that is late by δ reads the field of δ earlier: d holds −δ dB/dt, the same δ on all axes; with a
/// rate it grows in time. So the columns of an axis are −dB/dt and −t dB/dt of the field along it, Rη; the
/// axes' answers are put together by their information.
pub(crate) fn look(pair: &Pair) -> Result<Look, Error> {
    let columns = Columns::of(pair);
    let found = axes::try_each(pair.test.len(), |axis| columns.one(&pair.test[axis]))?;
    let (mut information, mut right) = ([[0.0; 2]; 2], [0.0; 2]);
    found.iter().for_each(|(_, fit)| add(&mut information, &mut right, fit));
    Ok(Look { axes: found.into_iter().map(|(axis, _)| axis).collect(), clock: solved(information, right) })
}

/// What is fitted to all axes: transforms of the reference and of drifts, and how fast the reference changes.
struct Columns<'a> {
    pair: &'a Pair,
    rates: [Vec<f64>; 3],
    transforms: Vec<Transform>,
}

impl<'a> Columns<'a> {
    fn of(pair: &'a Pair) -> Self {
        let transforms = beside(pair).map(|column| Transform::of(&column)).collect();
        let rates = pair.reference.each_ref().map(|column| seen_rate(pair, column));
        Self { transforms, rates, pair }
    }

    /// The fit of one axis, and what it says of the clock.
    fn one(&self, test: &[f64]) -> Result<(LookAxis, WeightedFit), Error> {
        let pair = self.pair;
        let base: Vec<&Transform> = self.transforms.iter().collect();
        let y = Transform::of(test);
        let alike = y.weights(pair.step_s, &|_| 1.0);
        let plain = spectral::weighted(&base, &y, &alike)?.coefficients;
        let mut eta = std::array::from_fn(|i| plain[i]);
        let mut noise = Noise::seen(&rest(beside(pair), test, &plain), pair)?;
        let under = spectral::regress_transforms(&base, &y, pair.step_s, &|f| noise.density(f))?;
        // Where the instruments do not answer alike at all frequencies, what is strong decides.
        let agree = spectral::agreement_p(
            (&under.least_squares[..3], &under.covariance),
            (&under.weighted[..3], &under.weighted_covariance),
        )?;
        let plain_only = agree < TOLD_BELOW;
        let mut turned_by = eta;
        let mut fit = WeightedFit { coefficients: under.weighted, covariance: under.weighted_covariance };
        for _ in 0..ROUNDS {
            turned_by = eta;
            let clock = clock_columns(pair, &turned(&self.rates, &turned_by));
            let transforms = clock.each_ref().map(|column| Transform::of(column));
            let all: Vec<&Transform> = transforms.iter().chain(base.iter().copied()).collect();
            let density = |f: f64| noise.density(f);
            fit = if plain_only {
                let both = spectral::regress_transforms(&all, &y, pair.step_s, &density)?;
                WeightedFit { coefficients: both.least_squares, covariance: both.covariance }
            } else {
                spectral::weighted(&all, &y, &y.weights(pair.step_s, &density))?
            };
            drop(transforms);
            eta = std::array::from_fn(|i| fit.coefficients[CLOCK + i]);
            let columns = clock.into_iter().map(Cow::Owned).chain(beside(pair));
            noise = Noise::seen(&rest(columns, test, &fit.coefficients), pair)?;
        }
        Ok((LookAxis { eta, noise, coefficients: fit.coefficients.clone(), turned_by }, fit))
    }
}

impl Look {
    /// What is left of each axis of another pair on the same grid: steps that were taken off before the look
    /// are in it. The clock shows in the slope of the field, that of `calm`: what only the reference read is
    /// no field.
    pub fn left(&self, pair: &Pair, calm: &Pair) -> Vec<Vec<f64>> {
        self.rests(pair, |eta| rate(calm, &turned(&calm.reference, eta)))
    }

    /// What is left of each axis where the field along it changes at this rate.
    fn rests(&self, pair: &Pair, rate: impl Fn(&[f64; 3]) -> Vec<f64> + Sync + Send) -> Vec<Vec<f64>> {
        axes::each(self.axes.len(), |axis| {
            let of = &self.axes[axis];
            let clock = clock_columns(pair, &rate(&of.turned_by));
            let columns = clock.into_iter().map(Cow::Owned).chain(beside(pair));
            rest(columns, &pair.test[axis], &of.coefficients)
        })
    }

    /// Gives the test instrument its most likely readings where rows are not whole: what the reference says,
    /// and what is left before and after.
    pub fn complete(&self, pair: &mut Pair) -> Result<(), Error> {
        let missing: Vec<bool> = pair.whole.iter().map(|whole| !whole).collect();
        if !missing.contains(&true) {
            return Ok(());
        }
        let left = self.rests(pair, |eta| seen_rate(pair, &turned(&pair.reference, eta)));
        for ((of, left), test) in self.axes.iter().zip(left).zip(&mut pair.test) {
            let filled = events::fill(&left, &missing, pair.step_s, &|f| of.noise.density(f))?;
            for (row, value) in test.iter_mut().enumerate().filter(|(row, _)| missing[*row]) {
                *value += filled[row] - left[row];
            }
        }
        Ok(())
    }

    /// The field along an axis.
    pub fn turned(&self, pair: &Pair, axis: usize) -> Vec<f64> {
        turned(&pair.reference, &self.axes[axis].turned_by)
    }

    /// Of an axis −dB/dt of the field along it (nothing in rows that are not whole), that field, and what the test
    /// instrument reads beside it, drifts and steps.
    pub fn parts(&self, pair: &Pair, axis: usize) -> [Vec<f64>; 3] {
        let turned = self.turned(pair, axis);
        let [late, _] = clock_columns(pair, &seen_rate(pair, &turned));
        let left = rest(beside(pair), &pair.test[axis], &self.axes[axis].coefficients[CLOCK..]);
        [late, turned, left]
    }
}

/// Adds one axis' knowledge of offset and rate, all its other unknowns free.
fn add(information: &mut [[f64; 2]; 2], right: &mut [f64; 2], fit: &WeightedFit) {
    let block = Mat::from_fn(2, 2, |i, j| fit.covariance[(i, j)]);
    let determinant = block[(0, 0)] * block[(1, 1)] - block[(0, 1)] * block[(1, 0)];
    let inverse = [
        [block[(1, 1)] / determinant, -block[(0, 1)] / determinant],
        [-block[(1, 0)] / determinant, block[(0, 0)] / determinant],
    ];
    for i in 0..2 {
        for j in 0..2 {
            information[i][j] += inverse[i][j];
            right[i] += inverse[i][j] * fit.coefficients[j];
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
