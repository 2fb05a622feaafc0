//! Rows of linear least squares.

use estimate::Svd;
use faer::{ColRef, Mat, Scale, Side};

use crate::Error;

/// Singular values below this share of the largest count as zero.
pub const RANK_TOLERANCE: f64 = 1e-9;
/// Variances of a correlation below this are rounding.
const ROUNDING: f64 = 1e-14;

/// Rows over their standard deviations: J x ≈ r.
#[derive(Clone, Debug)]
pub struct Linear {
    pub jacobian: Mat<f64>,
    pub right: Vec<f64>,
}

impl Linear {
    pub fn none(columns: usize) -> Self {
        Self { jacobian: Mat::zeros(0, columns), right: Vec::new() }
    }

    pub fn one(weights: &[f64], value: f64) -> Self {
        Self { jacobian: Mat::from_fn(1, weights.len(), |_, j| weights[j]), right: vec![value] }
    }

    /// Of a factor U whose first column is r, over the standard deviation of a row.
    pub fn of(upper: &Mat<f64>, variance: f64) -> Self {
        let upper = upper * Scale(1.0 / variance.max(f64::MIN_POSITIVE).sqrt());
        let jacobian = upper.subcols(1, upper.ncols() - 1).to_owned();
        Self { jacobian, right: upper.col(0).iter().copied().collect() }
    }

    /// That parameters have values with a covariance.
    pub fn known(values: &[f64], covariance: &Mat<f64>) -> Self {
        let jacobian = root(covariance);
        let right = (&jacobian * ColRef::from_slice(values)).iter().copied().collect();
        Self { jacobian, right }
    }

    pub fn is_empty(&self) -> bool {
        self.right.is_empty()
    }

    pub fn and(&self, other: &Self) -> Self {
        Self {
            jacobian: stacked(&self.jacobian, &other.jacobian),
            right: [self.right.as_slice(), &other.right].concat(),
        }
    }

    /// The same rows for the step from a state.
    pub fn about(&self, state: &[f64]) -> Self {
        let there = &self.jacobian * ColRef::from_slice(state);
        let right = self.right.iter().zip(there.iter()).map(|(value, there)| value - there).collect();
        Self { jacobian: self.jacobian.clone(), right }
    }

    /// The same rows where they ask for no step.
    pub fn fixed(&self) -> Self {
        Self { jacobian: self.jacobian.clone(), right: vec![0.0; self.right.len()] }
    }

    /// The same rows of more parameters, of which they say nothing.
    pub fn padded(&self, columns: usize) -> Self {
        let mut jacobian = Mat::zeros(self.jacobian.nrows(), columns);
        jacobian.subcols_mut(0, self.jacobian.ncols()).copy_from(&self.jacobian);
        Self { jacobian, right: self.right.clone() }
    }

    /// The decomposition of J.
    ///
    /// Errors: [`Error::Fit`] where there is none.
    pub fn svd(&self) -> Result<Svd, Error> {
        Ok(Svd::of(self.jacobian.as_ref(), RANK_TOLERANCE)?)
    }
}

pub fn stacked(above: &Mat<f64>, below: &Mat<f64>) -> Mat<f64> {
    let rows = above.nrows();
    Mat::from_fn(rows + below.nrows(), above.ncols(), |i, j| {
        if i < rows { above[(i, j)] } else { below[(i - rows, j)] }
    })
}

/// One at a place, else zeros.
pub fn unit(place: usize, count: usize) -> Vec<f64> {
    (0..count).map(|k| f64::from(u8::from(k == place))).collect()
}

/// Standard deviations by a covariance, none of them zero.
pub fn deviations(covariance: &Mat<f64>) -> Vec<f64> {
    (0..covariance.nrows()).map(|k| covariance[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect()
}

/// J with JᵀJ the inverse of a covariance; variances of the correlation below rounding count as that.
pub fn root(covariance: &Mat<f64>) -> Mat<f64> {
    rooted(covariance, |variance| Some(variance.max(ROUNDING)))
}

/// The same without the combinations that are fixed: those with less than a variance of the correlation.
pub fn root_of_free(covariance: &Mat<f64>, fixed: f64) -> Mat<f64> {
    rooted(covariance, |variance| Some(variance).filter(|variance| *variance > fixed))
}

fn rooted(covariance: &Mat<f64>, variance: impl Fn(f64) -> Option<f64>) -> Mat<f64> {
    let count = covariance.nrows();
    let scale = deviations(covariance);
    let correlation = Mat::from_fn(count, count, |i, j| covariance[(i, j)] / (scale[i] * scale[j]));
    let Ok(own) = correlation.self_adjoint_eigen(Side::Lower) else { return Mat::zeros(0, count) };
    let kept: Vec<(usize, f64)> =
        (0..count).filter_map(|k| Some((k, variance(own.S()[k])?.sqrt()))).collect();
    Mat::from_fn(kept.len(), count, |i, j| own.U()[(j, kept[i].0)] / (kept[i].1 * scale[j]))
}
