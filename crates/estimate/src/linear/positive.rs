//! Inverse and determinant of positive definite matrices.

use faer::{Mat, Side};

use crate::Error;

/// What the Cholesky factor of a matrix gives, its rows and columns scaled first.
#[derive(Clone, Debug)]
pub struct Positive {
    /// A⁻¹.
    pub inverse: Mat<f64>,
    /// ln |A|.
    pub log_determinant: f64,
}

impl Positive {
    /// Decomposes a symmetric matrix.
    ///
    /// # Errors
    ///
    /// [`Error::Decomposition`] unless it is positive definite.
    pub fn of(matrix: &Mat<f64>) -> Result<Self, Error> {
        let n = matrix.nrows();
        let scale: Vec<f64> = (0..n).map(|i| matrix[(i, i)].sqrt()).collect();
        let failed = |reason: &str| Error::Decomposition { rows: n, columns: n, reason: reason.into() };
        if scale.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
            return Err(failed("a column that does not vary, or is not finite"));
        }
        let scaled = Mat::from_fn(n, n, |i, j| matrix[(i, j)] / (scale[i] * scale[j]));
        let factor = scaled.as_ref().llt(Side::Lower).map_err(|error| failed(&format!("{error:?}")))?;
        let unit = Mat::<f64>::identity(n, n);
        let inverse = faer::linalg::solvers::Solve::solve(&factor, &unit);
        let lower = factor.L();
        let log_determinant = (0..n).map(|i| 2.0 * (lower[(i, i)] * scale[i]).ln()).sum();
        Ok(Self {
            inverse: Mat::from_fn(n, n, |i, j| inverse[(i, j)] / (scale[i] * scale[j])),
            log_determinant,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_by_two() {
        let found = Positive::of(&faer::mat![[4e6, 3.0], [3.0, 9e-6]]).expect("positive");
        // 36 − 9.
        assert!((found.log_determinant - 27_f64.ln()).abs() < 1e-12);
        assert!((found.inverse[(0, 0)] * 27.0 / 9e-6 - 1.0).abs() < 1e-12);
        assert!((found.inverse[(0, 1)] * 27.0 / -3.0 - 1.0).abs() < 1e-12);
        assert!(Positive::of(&faer::mat![[1.0, 2.0], [2.0, 1.0]]).is_err());
    }
}
