//! η from a stretch of the recording, and the noise under which it is found.

use std::ops::Range;

use common::{Axis, MatrixEstimate};
use estimate::periodogram::periodogram;
use estimate::whittle::{self, White, WhittleFit};
use estimate::{spectral, stats};
use faer::{Col, ColRef, Mat};

use crate::Error;
use crate::constancy::Estimate;
use crate::regression::AxisFit;
use joined::Pair;

/// Ordinates at the low end of a stretch's periodogram that its own η and straight line have emptied.
const EMPTIED: f64 = 4.5;
/// Ordinates from there to here are held against the noise of the whole.
const HELD: f64 = 20.5;
/// The noise of the whole is too high for the stretches below this probability: then steps or bends of the
/// offset are in it.
const TOO_HIGH: f64 = 1e-3;

pub fn whole(pair: &Pair, rows: &Range<usize>) -> usize {
    pair.whole[rows.clone()].iter().filter(|whole| **whole).count()
}

/// Noise of the difference: that of the whole, which knows the long periods best; or as stretches leave it
/// that have their own levels, where a step or a bend of the offset is in the whole and would pass for noise.
pub struct Noise<'a> {
    whole: &'a [AxisFit; 3],
    stretches: [Option<WhittleFit>; 3],
    step_s: f64,
    /// Squared correlations of the axes' differences, each weighed by its density.
    pub correlation_squared: [[f64; 3]; 3],
}

impl<'a> Noise<'a> {
    /// From what each stretch leaves with an η, a level and a straight line of its own.
    pub fn of(pair: &Pair, fits: &'a [AxisFit; 3], stretches: &[Range<usize>]) -> Result<Self, Error> {
        let one = |axis: Axis| of_stretches(pair, fits, axis, stretches);
        let mut noise = Self {
            whole: fits,
            stretches: [one(Axis::X)?, one(Axis::Y)?, one(Axis::Z)?],
            step_s: pair.step_s,
            correlation_squared: Default::default(),
        };
        for i in 0..3 {
            noise.correlation_squared[i][i] = 1.0;
            for j in 0..i {
                // The slopes of either on the other are ρ and 1/ρ times the same ratio.
                let slope = |a: usize, b: usize| -> Result<f64, Error> {
                    let columns = [fits[a].difference.clone()];
                    let density = |f: f64| noise.density(b, f);
                    let fit = spectral::regress(&columns, &fits[b].difference, pair.step_s, &density)?;
                    Ok(fit.weighted[0])
                };
                let square = (slope(i, j)? * slope(j, i)?).clamp(0.0, 1.0);
                noise.correlation_squared[i][j] = square;
                noise.correlation_squared[j][i] = square;
            }
        }
        Ok(noise)
    }

    /// One-sided density of an axis's difference, nT²/Hz.
    pub fn density(&self, axis: usize, frequency_hz: f64) -> f64 {
        match &self.stretches[axis] {
            Some(fit) => fit.level(0, self.step_s, frequency_hz),
            None => self.whole[axis].noise.level(frequency_hz),
        }
    }

    /// Above this there are no weights in one of the axes, Hz; infinite where there are everywhere.
    pub fn highest_hz(&self) -> f64 {
        self.whole.iter().map(|fit| fit.noise.highest_hz()).fold(f64::INFINITY, f64::min)
    }

    /// The same for weights: infinite where the instruments do not answer alike.
    pub fn weighing(&self, axis: usize, frequency_hz: f64) -> f64 {
        if frequency_hz > self.whole[axis].noise.highest_hz() {
            return f64::INFINITY;
        }
        self.density(axis, frequency_hz)
    }
}

/// The noise of what stretches leave, if that of the whole is too high for them.
fn of_stretches(
    pair: &Pair,
    fits: &[AxisFit; 3],
    axis: Axis,
    stretches: &[Range<usize>],
) -> Result<Option<WhittleFit>, Error> {
    let (j, step_s) = (axis.index(), pair.step_s);
    let whole = &fits[j].noise;
    let density = |f: f64| whole.level(f);
    let mut series = Vec::with_capacity(stretches.len());
    let (mut sum, mut freedom) = (0.0, 0.0);
    for rows in stretches {
        let (columns, y) = (columns(pair, rows), &pair.test[j][rows.clone()]);
        let fit = spectral::regress(&columns, y, step_s, &density)?;
        let explained = |row: usize| -> f64 {
            columns.iter().zip(&fit.weighted).map(|(column, c)| c * (column[row] - column[0])).sum()
        };
        let rest: Vec<f64> = y.iter().enumerate().map(|(row, y)| y - explained(row)).collect();
        let mut ordinates = periodogram(&rest, step_s)?;
        let [lowest, highest] = [EMPTIED, HELD].map(|order| order / ordinates.length_s);
        ordinates.bins.retain(|bin| bin.frequency_hz > lowest);
        for bin in ordinates.bins.iter().filter(|bin| bin.frequency_hz < highest) {
            sum += 2.0 * bin.count * bin.density / whole.level(bin.frequency_hz);
            freedom += 2.0 * bin.count;
        }
        series.push(ordinates);
    }
    let too_high = 1.0 - stats::chi_squared_p(sum, freedom) < TOO_HIGH;
    Ok(too_high.then(|| whittle::fit_with(&series, White::PerReading)).transpose()?)
}

/// The reference's x, y, z in some rows, and a straight line.
fn columns(pair: &Pair, rows: &Range<usize>) -> Vec<Vec<f64>> {
    let reference = pair.reference.iter().map(|column| column[rows.clone()].to_vec());
    reference.chain([line(rows.len())]).collect()
}

fn line(rows: usize) -> Vec<f64> {
    (0..rows).map(|row| row as f64 / rows as f64).collect()
}

/// The column of η of one axis from some rows, whose level and straight drift are free.
///
/// Noise of the reference that makes up the share κ of the difference biases it by −κ n C η/|η|², n the
/// samples and C its covariance: in the normal equations XᵀV⁻¹X η the noise adds κ n/|η|² to each diagonal
/// element, whatever its spectrum.
pub fn estimate(
    pair: &Pair,
    fits: &[AxisFit; 3],
    density: &dyn Fn(f64) -> f64,
    axis: Axis,
    rows: &Range<usize>,
) -> Result<Estimate, Error> {
    let j = axis.index();
    let y = &pair.test[j][rows.clone()];
    let fit = spectral::regress(&columns(pair, rows), y, pair.step_s, density)?;
    let covariance = Mat::from_fn(3, 3, |i, k| fit.weighted_covariance[(i, k)]);
    let bias = bias(&covariance, whole(pair, rows) as f64, &fits[j].fit.weighted);
    Ok(Estimate { value: fit.weighted[..3].to_vec(), covariance, bias, freedom: f64::INFINITY })
}

/// −n C η/|η|².
fn bias(covariance: &Mat<f64>, samples: f64, eta: &[f64]) -> Vec<f64> {
    let square: f64 = eta[..3].iter().map(|value| value * value).sum();
    (covariance * ColRef::from_slice(&eta[..3])).iter().map(|value| -samples / square * value).collect()
}

/// Several estimates of one η as one, weighed by their covariances.
pub fn pooled(estimates: &[Estimate]) -> Result<Estimate, Error> {
    let (mut information, mut right, mut biased) = (Mat::zeros(3, 3), Col::zeros(3), Col::zeros(3));
    for estimate in estimates {
        let inverse = inverse(&estimate.covariance)?;
        right += &inverse * ColRef::from_slice(&estimate.value);
        biased += &inverse * ColRef::from_slice(&estimate.bias);
        information += inverse;
    }
    let covariance = inverse(&information)?;
    let times = |vector: Col<f64>| (&covariance * vector).iter().copied().collect();
    Ok(Estimate { value: times(right), bias: times(biased), freedom: f64::INFINITY, covariance })
}

fn inverse(matrix: &Mat<f64>) -> Result<Mat<f64>, Error> {
    let small = nalgebra::Matrix3::from_fn(|i, k| matrix[(i, k)]);
    let inverse = small
        .try_inverse()
        .ok_or_else(|| Error::Unanswerable("the field does not vary in three directions there".into()))?;
    Ok(Mat::from_fn(3, 3, |i, k| inverse[(i, k)]))
}

pub fn documented(columns: [&Estimate; 3]) -> MatrixEstimate {
    let mut all = MatrixEstimate::default();
    for (axis, estimate) in Axis::ALL.into_iter().zip(columns) {
        let covariance = std::array::from_fn(|i| std::array::from_fn(|k| estimate.covariance[(i, k)]));
        all.put(axis, [estimate.value[0], estimate.value[1], estimate.value[2]], covariance);
    }
    all
}
