use faer::Mat;

use super::errors::Errors;
use crate::Error;
use crate::cross_spectrum::{WIDEST_BIN, bins};
use crate::linear::dot;
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
    /// The whitened weights of each β, squared and summed over [`bins`].
    pub influence: Vec<Vec<f64>>,
}

impl Regression {
    /// The whitened weights of one β of these columns and errors: their products are the covariance.
    pub fn weights(&self, columns: &[&[f64]], errors: &Errors, of: usize) -> Vec<f64> {
        let mut weights = vec![0.0; self.residual.len()];
        for (j, column) in columns.iter().enumerate() {
            add(&mut weights, self.covariance[(of, j)], &errors.whiten(column));
        }
        weights
    }
}

fn add(sum: &mut [f64], factor: f64, column: &[f64]) {
    sum.iter_mut().zip(column).for_each(|(sum, x)| *sum += factor * x);
}

/// (XᵀX)⁻¹.
fn inverse<C: AsRef<[f64]>>(x: &[C]) -> Result<Mat<f64>, Error> {
    let product = |i: usize, j: usize| dot(x[i].as_ref(), x[j].as_ref());
    Ok(Positive::of(&Mat::from_fn(x.len(), x.len(), product))?.inverse)
}

/// Rows of which the products are summed at once: the numbers of all columns there stay near the processor.
const BLOCK: usize = 1024;

/// β = (Xᵀ C⁻¹ X)⁻¹ Xᵀ C⁻¹ y with the covariance (Xᵀ C⁻¹ X)⁻¹, columns and y being transforms.
///
/// Errors: [`Error::TooFew`] for no more coefficients than columns; [`Error::Decomposition`] where the
/// columns depend on each other.
pub fn weighted(columns: &[&[f64]], y: &[f64], errors: &Errors) -> Result<Regression, Error> {
    let unknowns = columns.len();
    if y.len() <= unknowns {
        return Err(Error::TooFew { found: y.len(), unknowns });
    }
    let x: Vec<Vec<f64>> = columns.iter().map(|column| errors.whiten(column)).collect();
    let covariance = inverse(&x)?;
    let whitened = errors.whiten(y);
    let (mut coefficients, mut influence) = (Vec::new(), Vec::new());
    for i in 0..unknowns {
        let mut weights = vec![0.0; y.len()];
        x.iter().enumerate().for_each(|(j, x)| add(&mut weights, covariance[(i, j)], x));
        coefficients.push(dot(&weights, &whitened));
        let bins = bins(y.len(), WIDEST_BIN);
        influence.push(bins.map(|bin| dot(&weights[bin.clone()], &weights[bin])).collect());
    }
    drop(x);
    let mut residual = y.to_vec();
    for (column, coefficient) in columns.iter().zip(&coefficients) {
        add(&mut residual, -coefficient, column);
    }
    let mut leverage = vec![0.0; y.len()];
    for from in (0..y.len()).step_by(BLOCK) {
        let rows = from..(from + BLOCK).min(y.len());
        for (i, column) in columns.iter().enumerate() {
            let mut along = [0.0; BLOCK];
            for (j, x) in columns.iter().enumerate() {
                add(&mut along, covariance[(i, j)], &x[rows.clone()]);
            }
            let along = along.iter().zip(&column[rows.clone()]);
            leverage[rows.clone()].iter_mut().zip(along).for_each(|(h, (along, x))| *h += along * x);
        }
    }
    leverage.iter_mut().zip(&errors.variance).for_each(|(h, variance)| *h /= variance);
    Ok(Regression { coefficients, covariance, residual, leverage, influence })
}

/// The same beside least squares, β = (XᵀX)⁻¹ Xᵀ y, with its covariance (XᵀX)⁻¹ (XᵀCX) (XᵀX)⁻¹ under these
/// errors.
///
/// Errors: as [`weighted`].
pub fn regress(columns: &[&[f64]], y: &[f64], errors: &Errors) -> Result<SpectralFit, Error> {
    let unknowns = columns.len();
    let found = weighted(columns, y, errors)?;
    let independent = inverse(columns)?;
    let mut noisy = Mat::zeros(unknowns, unknowns);
    for (j, column) in columns.iter().enumerate() {
        let times = errors.times(column);
        columns.iter().enumerate().for_each(|(i, other)| noisy[(i, j)] = dot(other, &times));
    }
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

/// What one more column would explain beside others.
pub struct Projection {
    columns: Vec<Vec<f64>>,
    inverse: Mat<f64>,
    y: Vec<f64>,
}

impl Projection {
    /// Beside `columns`, in y; all are transforms.
    ///
    /// Errors: as [`weighted`].
    pub fn of(columns: &[&[f64]], y: &[f64], errors: &Errors) -> Result<Self, Error> {
        let columns: Vec<Vec<f64>> = columns.iter().map(|column| errors.whiten(column)).collect();
        Ok(Self { inverse: inverse(&columns)?, columns, y: errors.whiten(y) })
    }

    /// A column, whitened, less what the others explain of it, of unit length; None where nothing is left.
    pub fn direction(&self, column: &[f64], errors: &Errors) -> Option<Vec<f64>> {
        const NOTHING: f64 = 1e-12;
        let whitened = errors.whiten(column);
        let size = dot(&whitened, &whitened);
        let mut rest = self.rest(whitened);
        let left = dot(&rest, &rest);
        if left.is_nan() || left <= NOTHING * size {
            return None;
        }
        let length = left.sqrt();
        rest.iter_mut().for_each(|rest| *rest /= length);
        Some(rest)
    }

    /// The coefficients of further columns beside the others; None where they depend on each other or these.
    pub fn coefficients(&self, columns: &[&[f64]], errors: &Errors) -> Option<Vec<f64>> {
        let rests: Vec<Vec<f64>> = columns.iter().map(|column| self.rest(errors.whiten(column))).collect();
        let inverse = inverse(&rests).ok()?;
        let right: Vec<f64> = rests.iter().map(|rest| dot(rest, &self.y)).collect();
        Some((0..rests.len()).map(|i| (0..rests.len()).map(|j| inverse[(i, j)] * right[j]).sum()).collect())
    }

    /// What the columns do not explain of a whitened one.
    fn rest(&self, mut column: Vec<f64>) -> Vec<f64> {
        let products: Vec<f64> = self.columns.iter().map(|x| dot(x, &column)).collect();
        for (i, x) in self.columns.iter().enumerate() {
            let share: f64 = (0..products.len()).map(|j| self.inverse[(i, j)] * products[j]).sum();
            add(&mut column, -share, x);
        }
        column
    }

    /// The standard normal z of a direction; z² is what the sum of squares falls by.
    pub fn score(&self, direction: &[f64]) -> f64 {
        dot(direction, &self.y)
    }
}
