//! η and d, with the source's intervals and with ones that hold for errors with memory.

use common::{
    Axis, ClockDifference, DifferentialCalibration, DifferentialFit, MatrixElement, PerAxis, Quantity,
};
use estimate::spectral::{self, SpectralFit};
use estimate::{hac, stats};
use faer::Mat;

use crate::difference::{self, Noise};
use crate::series::Pair;
use crate::{Error, words};

/// Rounds of fitting the noise to the difference and the matrix under that noise.
const ROUNDS: usize = 3;
const DAY_S: f64 = 86_400.0;
/// A clock's offset is told below this probability.
const TOLD_BELOW: f64 = 0.01;

/// The fit of one axis of the test instrument.
pub struct AxisFit {
    /// Coefficients of the reference's x, y, z (nT/nT) and of the straight drift (nT/day).
    pub fit: SpectralFit,
    /// Noise of the difference.
    pub noise: Noise,
    /// T − R η − drift less its mean, η as weighted, nT.
    pub difference: Vec<f64>,
    /// Mean of T − R η, nT.
    pub offset_nt: f64,
    newey_west: Vec<f64>,
}

/// Fits each axis of the test instrument.
pub fn fit(pair: &Pair<'_>) -> Result<[AxisFit; 3], Error> {
    let days = days(pair);
    let one = |axis: Axis| one(pair, &days, &pair.test[axis.index()]);
    Ok([one(Axis::X)?, one(Axis::Y)?, one(Axis::Z)?])
}

/// Days from the middle of the recording.
fn days(pair: &Pair<'_>) -> Vec<f64> {
    let middle = 0.5 * (pair.whole.len() as f64 - 1.0) * pair.step_s;
    (0..pair.whole.len()).map(|row| (row as f64 * pair.step_s - middle) / DAY_S).collect()
}

/// The matrix and the difference, as a document has them.
pub fn calibrate(pair: &Pair<'_>, fits: &[AxisFit; 3]) -> Result<DifferentialCalibration, Error> {
    let rows = pair.whole.len();
    let mut fit = DifferentialFit {
        recording: pair.recording.id.clone(),
        samples: pair.samples(),
        step_s: pair.step_s,
        missing: rows - pair.samples(),
        quoted: words::quoted(),
        ..DifferentialFit::default()
    };
    let mut matrix = [[0.0; 3]; 3];
    let mut covariance = vec![vec![0.0; 9]; 9];
    let mut offsets = PerAxis::default();
    for (axis, found) in Axis::ALL.into_iter().zip(fits) {
        let j = axis.index();
        let mut described = difference::describe(&found.difference, &found.noise)?;
        let drift = found.fit.weighted_covariance[(3, 3)].sqrt();
        described.drift_nt_per_day = Quantity::new(found.fit.weighted[3], drift);
        let variance = described.rms_nt.powi(2);
        for (i, reference) in Axis::ALL.into_iter().enumerate() {
            matrix[i][j] = found.fit.weighted[i];
            for k in 0..3 {
                covariance[3 * j + i][3 * j + k] = found.fit.weighted_covariance[(i, k)];
            }
            let element = MatrixElement {
                least_squares: found.fit.least_squares[i],
                std_independent: (found.fit.independent[(i, i)] * variance).sqrt(),
                std_newey_west: found.newey_west[i],
                std_noise: found.fit.covariance[(i, i)].sqrt(),
                weighted: found.fit.weighted[i],
                weighted_std: found.fit.weighted_covariance[(i, i)].sqrt(),
            };
            fit.elements.insert(format!("{reference}{axis}"), element);
        }
        // The mean of the noise is what is lowest in its spectrum: that of one over the length.
        let lowest = found.noise.density(1.0 / (rows as f64 * pair.step_s)) / (rows as f64 * pair.step_s);
        *offsets.entry(axis) = Some(Quantity::new(found.offset_nt, lowest.sqrt()));
        *fit.axes.entry(axis) = Some(described);
    }
    fit.clock = clock(pair, fits, &days(pair))?;
    fit.findings = words::findings(&fit, TOLD_BELOW);
    let order = Axis::ALL.iter().flat_map(|j| (0..3).map(move |i| format!("matrix[{i}][{}]", j.index())));
    Ok(DifferentialCalibration {
        matrix: Some(matrix),
        offset_nt: Some(offsets),
        covariance: Some(covariance),
        covariance_order: Some(order.collect()),
        fit: Some(Box::new(fit)),
        ..DifferentialCalibration::default()
    })
}

/// One axis: the reference's three axes and a straight drift, under the noise of what they leave.
fn one(pair: &Pair<'_>, days: &[f64], test: &[f64]) -> Result<AxisFit, Error> {
    let mut columns: Vec<Vec<f64>> = pair.reference.to_vec();
    columns.push(days.to_vec());
    let mut fit = spectral::regress(&columns, test, pair.step_s, &|_| 1.0)?;
    let mut difference = rest(&columns, test, &fit.least_squares);
    let mut noise = Noise::of(&difference.0, pair.step_s)?;
    for _ in 0..ROUNDS {
        fit = spectral::regress(&columns, test, pair.step_s, &|frequency| noise.density(frequency))?;
        difference = rest(&columns, test, &fit.weighted);
        noise = Noise::of(&difference.0, pair.step_s)?;
    }
    let plain = rest(&columns, test, &fit.least_squares).0;
    let means: Vec<f64> = columns.iter().map(|column| mean(column)).collect();
    let design = Mat::from_fn(test.len(), columns.len(), |i, j| columns[j][i] - means[j]);
    let robust = hac::newey_west(design.as_ref(), &plain, fit.independent.as_ref(), hac::lags(test.len()));
    let offset_nt = mean(test) - (0..3).map(|i| fit.weighted[i] * mean(&pair.reference[i])).sum::<f64>();
    Ok(AxisFit {
        newey_west: (0..3).map(|i| robust[(i, i)].sqrt()).collect(),
        fit,
        noise,
        difference: difference.0,
        offset_nt,
    })
}

fn mean(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let first = values.iter().sum::<f64>() / count;
    first + values.iter().map(|value| value - first).sum::<f64>() / count
}

/// What the columns leave, less its mean, and that mean.
fn rest(columns: &[Vec<f64>], y: &[f64], coefficients: &[f64]) -> (Vec<f64>, f64) {
    let means: Vec<f64> = columns.iter().map(|column| mean(column)).collect();
    let middle = mean(y);
    let left: Vec<f64> = (0..y.len())
        .map(|row| {
            let explained: f64 =
                (0..columns.len()).map(|j| coefficients[j] * (columns[j][row] - means[j])).sum();
            y[row] - middle - explained
        })
        .collect();
    (left, middle)
}

/// A clock that is late by δ reads the field of δ earlier: d holds −δ dB/dt, the same δ on all axes; with a rate it grows in
/// time.
fn clock(pair: &Pair<'_>, fits: &[AxisFit], days: &[f64]) -> Result<Option<ClockDifference>, Error> {
    let (mut information, mut right) = ([[0.0; 2]; 2], [0.0; 2]);
    for found in fits {
        let turned: Vec<f64> = (0..pair.whole.len())
            .map(|row| (0..3).map(|i| found.fit.weighted[i] * pair.reference[i][row]).sum())
            .collect();
        let rate = slope(&turned, pair.step_s);
        let mut columns: Vec<Vec<f64>> = vec![
            rate.iter().map(|r| -r).collect(),
            rate.iter().zip(days).map(|(r, day)| -r * day * DAY_S * 1e-6).collect(),
        ];
        columns.extend(pair.reference.iter().cloned());
        columns.push(days.to_vec());
        let density = |frequency: f64| found.noise.density(frequency);
        let fit = spectral::regress(&columns, &found.difference, pair.step_s, &density)?;
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
    let [[a, b], [c, d]] = information;
    let determinant = a * d - b * c;
    if determinant.is_nan() || determinant <= 0.0 {
        return Ok(None);
    }
    let offset = (d * right[0] - b * right[1]) / determinant;
    let rate = (a * right[1] - c * right[0]) / determinant;
    Ok(Some(ClockDifference {
        offset_s: Quantity::new(offset, (d / determinant).sqrt()),
        rate_ppm: Quantity::new(rate, (a / determinant).sqrt()),
    }))
}

/// Central differences, nT/s; one-sided at the ends.
fn slope(values: &[f64], step_s: f64) -> Vec<f64> {
    let last = values.len() - 1;
    (0..values.len())
        .map(|row| {
            let (from, to) = (row.saturating_sub(1), (row + 1).min(last));
            (values[to] - values[from]) / ((to - from) as f64 * step_s)
        })
        .collect()
}

/// Probability of a quantity so far from zero by chance.
pub fn p_of(quantity: &Quantity) -> f64 {
    stats::two_sided_p(quantity.value() / quantity.std().unwrap_or(f64::INFINITY), f64::INFINITY)
}
