//! Covariances: matrices in programs, lists of rows in documents.

use faer::{ColRef, Mat, RowRef};

/// The rows of a matrix, as documents hold them.
pub fn rows(matrix: &Mat<f64>) -> Vec<Vec<f64>> {
    matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
}

/// The matrix with these rows.
pub fn matrix(rows: &[Vec<f64>]) -> Mat<f64> {
    Mat::from_fn(rows.len(), rows.first().map_or(0, Vec::len), |i, j| rows[i][j])
}

/// Covariance of two sums of quantities with a covariance, by their weights.
pub fn between(covariance: &Mat<f64>, one: &[f64], other: &[f64]) -> f64 {
    RowRef::from_slice(one) * covariance * ColRef::from_slice(other)
}
