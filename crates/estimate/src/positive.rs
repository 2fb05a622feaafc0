//! What symmetric matrices are decomposed to, and the inverse and determinant of positive definite ones.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, MatRef, Side};

use crate::Error;

/// The Cholesky factor of a matrix that is positive definite.
pub fn cholesky(matrix: MatRef<'_, f64>) -> Result<Llt<f64>, Error> {
    matrix.llt(Side::Lower).map_err(|error| failed(matrix, format!("{error:?}")))
}

/// Eigenvalues, rising, and eigenvectors of a symmetric matrix.
pub fn eigen(matrix: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), Error> {
    // faer does not take a matrix without rows.
    if matrix.nrows() == 0 {
        return Ok((Vec::new(), Mat::new()));
    }
    let found =
        matrix.self_adjoint_eigen(Side::Lower).map_err(|error| failed(matrix, format!("{error:?}")))?;
    Ok((found.S().column_vector().iter().copied().collect(), found.U().to_owned()))
}

fn failed(matrix: MatRef<'_, f64>, reason: String) -> Error {
    Error::Decomposition { rows: matrix.nrows(), columns: matrix.ncols(), reason }
}

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
    /// Errors: [`Error::Decomposition`] unless it is positive definite.
    pub fn of(matrix: &Mat<f64>) -> Result<Self, Error> {
        let n = matrix.nrows();
        let scale: Vec<f64> = (0..n).map(|i| matrix[(i, i)].sqrt()).collect();
        if scale.iter().any(|s| !(*s > 0.0 && s.is_finite())) {
            return Err(failed(matrix.as_ref(), "a column that does not vary, or is not finite".into()));
        }
        let scaled = Mat::from_fn(n, n, |i, j| matrix[(i, j)] / (scale[i] * scale[j]));
        let factor = cholesky(scaled.as_ref())?;
        let inverse = factor.solve(Mat::<f64>::identity(n, n));
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
        assert!(eigen(Mat::zeros(0, 0).as_ref()).is_ok_and(|(values, _)| values.is_empty()));
    }
}
