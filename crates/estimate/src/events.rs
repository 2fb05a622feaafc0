//! Steps and spikes, by matched filters over all rows at once: in a long even series whose noise has a known
//! spectrum ([`Search`]), and in a whitened residual beside what else is fitted ([`Departures`]).

mod departures;

pub use departures::{Departures, Product, correlate};

use std::ops::Range;
use std::sync::Arc;

use fourier::Complex;

use crate::Error;
use crate::stats::{coverage_factor, mean};

/// What is slower than so many samples, as drift, counts as unknown: it cannot look like steps.
pub const MEMORY: usize = 256;
/// Samples on either side of a missing one that tell of it.
const AROUND: usize = 4096;
/// Rows at either end where nothing is looked for.
const ENDS: usize = 2;
/// A shape is looked for where the jump between the ends leaves so much of what is known of it.
const LEFT: f64 = 0.1;
/// Most rounds in which missing samples are filled.
const FILLS: usize = 60;
/// They are filled when what is left of the equations is less than this share.
const FILLED: f64 = 1e-4;
/// Fewer samples than these have no events worth the name.
const LEAST: usize = 16;

/// The shape of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Everything from the row on is higher by the size.
    Step,
    /// The row alone is higher by the size.
    Spike,
}

/// The matched filter for one series.
///
/// With the differences e_m = d_m − d_(m−1), e_0 = d_0 − d_(n−1), their transform E_k and its variance under
/// noise of the one-sided density P, S_k = n P(f_k)/(2Δt) · 4 sin²(πk/n), a step at row m is a delta in e, a
/// spike a delta and its opposite in the next row. The generalised least-squares size of a delta at m is
/// g_m/K_0 with g_m = Σ E_k e^(2πi k m/n)/S_k and K_m = Σ e^(2πi k m/n)/S_k, its variance 1/K_0. The sums
/// leave out what is slower than 256 samples, which is the same as noise without bound there. The jump from
/// the last sample to the first is an unknown of each fit: g'_m = g_m − g_0 K_m/K_0.
///
/// Source: L. A. Wainstein and V. D. Zubakov, Extraction of Signals from Noise, Prentice-Hall 1962, chapter
/// 3.
pub struct Search {
    filtered: Vec<f64>,
    filter: Arc<Filter>,
}

/// The whitening of a series' differences.
struct Filter {
    /// 1/S_k.
    weights: Vec<f64>,
    /// K_m.
    kernel: Vec<f64>,
}

impl Filter {
    fn new(n: usize, step_s: f64, density: &dyn Fn(f64) -> f64) -> Result<Self, Error> {
        if n < LEAST {
            return Err(Error::TooFew { found: n, unknowns: LEAST });
        }
        let from = (n / MEMORY).max(1);
        let mut weights = vec![0.0; n / 2 + 1];
        for (k, weight) in weights.iter_mut().enumerate().skip(from) {
            let rise = (std::f64::consts::PI * k as f64 / n as f64).sin();
            let variance = n as f64 * density(k as f64 / (n as f64 * step_s)) * 2.0 * rise * rise / step_s;
            if !(variance > 0.0 && variance.is_finite()) {
                return Err(Error::Series("whose noise has a density that is not above zero"));
            }
            *weight = 1.0 / variance;
        }
        let kernel = fourier::inverse(weights.iter().map(Complex::from).collect(), n);
        Ok(Self { weights, kernel })
    }

    /// g' of a series.
    fn apply(&self, series: &[f64]) -> Vec<f64> {
        let n = series.len();
        assert_eq!(n, self.kernel.len(), "samples of the series");
        let difference = |m: usize| series[m] - series[if m == 0 { n - 1 } else { m - 1 }];
        let mut transform = fourier::forward((0..n).map(difference).collect());
        transform.iter_mut().zip(&self.weights).for_each(|(e, weight)| *e *= weight);
        let mut filtered = fourier::inverse(transform, n);
        let wrap = filtered[0] / self.kernel[0];
        filtered.iter_mut().zip(&self.kernel).for_each(|(g, k)| *g -= wrap * k);
        filtered
    }

    /// Root of the information of a shape at a row; zero where nothing is looked for.
    fn information_root(&self, shape: Shape, row: usize) -> f64 {
        let n = self.kernel.len();
        if row < ENDS || row + ENDS >= n {
            return 0.0;
        }
        let k = &self.kernel;
        let (all, with_jump) = match shape {
            Shape::Step => (k[0], k[row]),
            Shape::Spike => (2.0 * (k[0] - k[1]), k[row] - k[row + 1]),
        };
        let information = all - with_jump * with_jump / k[0];
        if information > LEFT * all { information.sqrt() } else { 0.0 }
    }
}

impl Search {
    /// The filter of a series with noise of the one-sided density `density` (square of the series' unit, per
    /// Hz).
    ///
    /// Errors: [`Error::TooFew`] for fewer than 16 samples, [`Error::Series`] for samples that are not
    /// finite or a density that is not above zero.
    pub fn new(series: &[f64], step_s: f64, density: &dyn Fn(f64) -> f64) -> Result<Self, Error> {
        Self::with(Arc::new(Filter::new(series.len(), step_s, density)?), series)
    }

    /// The same filter for another series.
    ///
    /// Errors: as [`Search::new`].
    pub fn again(&self, series: &[f64]) -> Result<Self, Error> {
        Self::with(self.filter.clone(), series)
    }

    fn with(filter: Arc<Filter>, series: &[f64]) -> Result<Self, Error> {
        let filtered = filter.apply(series);
        if !filtered[series.len() - 1].is_finite() {
            return Err(Error::Series("with samples that are not finite"));
        }
        Ok(Self { filtered, filter })
    }

    /// How many samples.
    pub fn rows(&self) -> usize {
        self.filtered.len()
    }

    /// Σ of the series with a shape at a row, whitened.
    pub fn score(&self, shape: Shape, row: usize) -> f64 {
        match shape {
            Shape::Step => self.filtered[row],
            Shape::Spike => self.filtered[row] - self.filtered[row + 1],
        }
    }

    /// Size over uncertainty of a shape at a row; zero where nothing is looked for.
    pub fn ratio(&self, shape: Shape, row: usize) -> f64 {
        let root = self.filter.information_root(shape, row);
        if root > 0.0 { self.score(shape, row) / root } else { 0.0 }
    }

    /// Size of a shape at a row and its standard uncertainty; infinite where nothing is looked for.
    pub fn size(&self, shape: Shape, row: usize) -> (f64, f64) {
        let root = self.filter.information_root(shape, row);
        if root > 0.0 { (self.score(shape, row) / (root * root), 1.0 / root) } else { (0.0, f64::INFINITY) }
    }

    /// What the scores of steps at two rows have in common: their covariance, under the noise.
    pub fn products(&self, row: usize, other: usize) -> f64 {
        let k = &self.filter.kernel;
        k[row.abs_diff(other)] - k[row] * k[other] / k[0]
    }
}

/// A series whose missing samples have their most likely values under noise of the one-sided density
/// `density`: those at which a spike would have the size 0. A long gap keeps in part what it was filled with.
///
/// What is more than 4096 samples from a missing one says nothing of it: each group of missing samples is
/// filled with those around it.
///
/// With x the missing values, e(x) the differences and S their spectrum, eᵀ S⁻¹ e is least: conjugate
/// gradients.
///
/// Source: B. Abraham, Missing observations in time series, Commun. Stat. A 10 (1981) 1643–1653.
///
/// Errors: as [`Search::new`].
pub fn fill(
    series: &[f64],
    missing: &[bool],
    step_s: f64,
    density: &dyn Fn(f64) -> f64,
) -> Result<Vec<f64>, Error> {
    let mut filled = series.to_vec();
    for rows in groups(missing) {
        let part = fill_group(&series[rows.clone()], &missing[rows.clone()], step_s, density)?;
        filled[rows].copy_from_slice(&part);
    }
    Ok(filled)
}

/// Missing samples nearer to each other than twice what tells of them, with as much before and after.
fn groups(missing: &[bool]) -> Vec<Range<usize>> {
    let mut groups: Vec<Range<usize>> = Vec::new();
    for row in (0..missing.len()).filter(|row| missing[*row]) {
        let (from, to) = (row.saturating_sub(AROUND), (row + AROUND + 1).min(missing.len()));
        match groups.last_mut() {
            Some(group) if from <= group.end => group.end = to,
            _ => groups.push(from..to),
        }
    }
    groups
}

fn fill_group(
    series: &[f64],
    missing: &[bool],
    step_s: f64,
    density: &dyn Fn(f64) -> f64,
) -> Result<Vec<f64>, Error> {
    let n = series.len();
    let rows: Vec<usize> = (0..n).filter(|row| missing[*row]).collect();
    if rows.len() == n {
        return Ok(series.to_vec());
    }
    let filter = Filter::new(n, step_s, density)?;
    let middle = mean(series);
    let mut filled: Vec<f64> = series.iter().map(|value| value - middle).collect();
    let scores = |series: &[f64]| -> Vec<f64> {
        let g = filter.apply(series);
        rows.iter().map(|row| g[*row] - g[(*row + 1) % n]).collect()
    };
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut left: Vec<f64> = scores(&filled).iter().map(|score| -score).collect();
    let mut direction = left.clone();
    let mut squares = dot(&left, &left);
    let enough = FILLED * FILLED * squares;
    for _ in 0..FILLS {
        if squares <= enough {
            break;
        }
        let mut along = vec![0.0; n];
        rows.iter().zip(&direction).for_each(|(row, value)| along[*row] = *value);
        let product = scores(&along);
        let curvature = dot(&direction, &product);
        if curvature <= 0.0 {
            break;
        }
        let step = squares / curvature;
        rows.iter().zip(&direction).for_each(|(row, value)| filled[*row] += step * value);
        left.iter_mut().zip(&product).for_each(|(left, product)| *left -= step * product);
        let next = dot(&left, &left);
        direction.iter_mut().zip(&left).for_each(|(value, left)| *value = left + next / squares * *value);
        squares = next;
    }
    filled.iter_mut().for_each(|value| *value += middle);
    if filled.iter().any(|value| !value.is_finite()) {
        return Err(Error::Series("with samples that are not finite"));
    }
    Ok(filled)
}

/// The |z| that a step or spike at any of some rows exceeds with the probability `false_alarm`.
pub fn threshold(rows: usize, false_alarm: f64) -> f64 {
    coverage_factor(1.0 - false_alarm / (2.0 * rows as f64), f64::INFINITY)
}
