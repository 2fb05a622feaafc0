use faer::Mat;

use super::Errors;
use crate::Error;
use crate::positive::Positive;
use crate::spectral::SpectralFit;

/// A regression weighted by its errors' covariance, from transforms.
#[derive(Clone, Debug)]
pub struct Regression {
    /// β.
    pub coefficients: Vec<f64>,
    /// Its covariance.
    pub covariance: Mat<f64>,
    /// y − X β.
    pub residual: Vec<f64>,
    /// The share h of the variance of each coefficient that the columns take.
    pub leverage: Vec<f64>,
    /// The whitened weights of each β: their sums of products are the covariance.
    pub weights: Vec<Vec<f64>>,
}

/// β = (Xᵀ C⁻¹ X)⁻¹ Xᵀ C⁻¹ y with the covariance (Xᵀ C⁻¹ X)⁻¹, columns and y being transforms.
///
/// # Errors
///
/// [`Error::TooFew`] for no more coefficients than columns; [`Error::Decomposition`] where the columns depend on each other.
pub fn weighted(columns: &[&[f64]], y: &[f64], errors: &Errors) -> Result<Regression, Error> {
    let unknowns = columns.len();
    if y.len() <= unknowns {
        return Err(Error::TooFew { found: y.len(), unknowns });
    }
    let x: Vec<Vec<f64>> = columns.iter().map(|column| errors.whiten(column)).collect();
    let covariance = Positive::of(&Mat::from_fn(unknowns, unknowns, |i, j| dot(&x[i], &x[j])))?.inverse;
    let weights: Vec<Vec<f64>> = (0..unknowns)
        .map(|i| {
            let mut weights = vec![0.0; y.len()];
            for (j, x) in x.iter().enumerate() {
                weights.iter_mut().zip(x).for_each(|(weight, x)| *weight += covariance[(i, j)] * x);
            }
            weights
        })
        .collect();
    let whitened = errors.whiten(y);
    let coefficients: Vec<f64> = weights.iter().map(|weights| dot(weights, &whitened)).collect();
    let mut residual = y.to_vec();
    for (column, coefficient) in columns.iter().zip(&coefficients) {
        residual.iter_mut().zip(*column).for_each(|(left, x)| *left -= coefficient * x);
    }
    let mut leverage = vec![0.0; y.len()];
    for (i, column) in columns.iter().enumerate() {
        for (j, other) in columns.iter().enumerate() {
            let share = covariance[(i, j)];
            leverage.iter_mut().zip(*column).zip(*other).for_each(|((h, x), other)| *h += share * x * other);
        }
    }
    leverage.iter_mut().zip(&errors.variance).for_each(|(h, variance)| *h /= variance);
    Ok(Regression { coefficients, covariance, residual, leverage, weights })
}

/// The same beside least squares, β = (XᵀX)⁻¹ Xᵀ y, with its covariance (XᵀX)⁻¹ (XᵀCX) (XᵀX)⁻¹ under these errors.
///
/// # Errors
///
/// As [`weighted`].
pub fn regress(columns: &[&[f64]], y: &[f64], errors: &Errors) -> Result<SpectralFit, Error> {
    let unknowns = columns.len();
    let found = weighted(columns, y, errors)?;
    let independent =
        Positive::of(&Mat::from_fn(unknowns, unknowns, |i, j| dot(columns[i], columns[j])))?.inverse;
    let noisy: Vec<Vec<f64>> = columns.iter().map(|column| errors.times(column)).collect();
    let noisy = Mat::from_fn(unknowns, unknowns, |i, j| dot(columns[i], &noisy[j]));
    let right: Vec<f64> = columns.iter().map(|column| dot(column, y)).collect();
    Ok(SpectralFit {
        least_squares: (0..unknowns)
            .map(|i| (0..unknowns).map(|j| independent[(i, j)] * right[j]).sum())
            .collect(),
        covariance: &independent * &noisy * &independent,
        weighted: found.coefficients,
        weighted_covariance: found.covariance,
        independent,
    })
}

/// Σ a_i b_i, in eight sums, which need not wait for one another.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    const SUMS: usize = 8;
    let mut sums = [0.0; SUMS];
    let count = a.len().min(b.len());
    let (a, b) = (a[..count].chunks_exact(SUMS), b[..count].chunks_exact(SUMS));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        sums.iter_mut().zip(a).zip(b).for_each(|((sum, a), b)| *sum += a * b);
    }
    sums.iter().sum::<f64>() + rest
}

/// What one more column would explain beside others.
pub struct Projection {
    columns: Vec<Vec<f64>>,
    inverse: Mat<f64>,
    y: Vec<f64>,
}

impl Projection {
    /// Beside `columns`, in y; all are transforms.
    ///
    /// # Errors
    ///
    /// As [`weighted`].
    pub fn of(columns: &[&[f64]], y: &[f64], errors: &Errors) -> Result<Self, Error> {
        let unknowns = columns.len();
        let columns: Vec<Vec<f64>> = columns.iter().map(|column| errors.whiten(column)).collect();
        let inverse =
            Positive::of(&Mat::from_fn(unknowns, unknowns, |i, j| dot(&columns[i], &columns[j])))?.inverse;
        Ok(Self { columns, inverse, y: errors.whiten(y) })
    }

    /// A column, whitened, less what the others explain of it, of unit length; None where nothing is left.
    pub fn direction(&self, column: &[f64], errors: &Errors) -> Option<Vec<f64>> {
        const NOTHING: f64 = 1e-12;
        let mut rest = errors.whiten(column);
        let size = dot(&rest, &rest);
        let products: Vec<f64> = self.columns.iter().map(|x| dot(x, &rest)).collect();
        for (i, x) in self.columns.iter().enumerate() {
            let share: f64 = (0..products.len()).map(|j| self.inverse[(i, j)] * products[j]).sum();
            rest.iter_mut().zip(x).for_each(|(rest, x)| *rest -= share * x);
        }
        let left = dot(&rest, &rest);
        if left.is_nan() || left <= NOTHING * size {
            return None;
        }
        let length = left.sqrt();
        rest.iter_mut().for_each(|rest| *rest /= length);
        Some(rest)
    }

    /// The standard normal z of a direction: the column's coefficient over its standard deviation. z² is what the sum of
    /// squares falls by.
    pub fn score(&self, direction: &[f64]) -> f64 {
        dot(direction, &self.y)
    }
}
