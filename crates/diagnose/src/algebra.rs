//! Sums of squares, projections and inverses of columns.

use faer::{Mat, MatRef, Side};

use crate::Error;

/// Directions of scaled columns with less than this share of their squared length are rounding.
const ROUNDING: f64 = 1e-12;

pub fn square(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum()
}

/// What some orthonormal columns leave of a series, zero in further rows, which are those of prior knowledge.
pub fn left<'b>(basis: impl Iterator<Item = &'b [f64]>, series: &[f64]) -> Vec<f64> {
    let mut left = series.to_vec();
    for column in basis {
        left.resize(column.len(), 0.0);
        let along: f64 = column.iter().zip(&left).map(|(b, l)| b * l).sum();
        left.iter_mut().zip(column).for_each(|(l, b)| *l -= along * b);
    }
    left
}

pub fn columns(matrix: &Mat<f64>) -> impl Iterator<Item = &[f64]> {
    (0..matrix.ncols()).map(|j| matrix.col_as_slice(j))
}

/// An orthonormal basis of columns.
pub fn orthonormal(columns: &Mat<f64>) -> Result<Mat<f64>, Error> {
    Ok(columns * root_of_inverse(columns.as_ref())?)
}

/// The inverse of JᵀJ along the directions that show; zero across them.
pub fn inverse(jacobian: MatRef<'_, f64>) -> Result<Mat<f64>, Error> {
    let root = root_of_inverse(jacobian)?;
    Ok(&root * root.transpose())
}

fn root_of_inverse(columns: MatRef<'_, f64>) -> Result<Mat<f64>, Error> {
    let count = columns.ncols();
    let gram = estimate::gram(columns);
    let scale: Vec<f64> =
        (0..count).map(|j| if gram[(j, j)] > 0.0 { gram[(j, j)].sqrt().recip() } else { 0.0 }).collect();
    let scaled = Mat::from_fn(count, count, |i, j| scale[i] * gram[(i, j)] * scale[j]);
    let failed = |reason: String| estimate::Error::Decomposition { rows: count, columns: count, reason };
    let eigen = scaled.self_adjoint_eigen(Side::Lower).map_err(|error| failed(format!("{error:?}")))?;
    let values: Vec<f64> = (0..count).map(|k| eigen.S().column_vector()[k]).collect();
    let along: Vec<usize> = (0..count).filter(|k| values[*k] > ROUNDING).collect();
    Ok(Mat::from_fn(count, along.len(), |j, k| scale[j] * eigen.U()[(j, along[k])] / values[along[k]].sqrt()))
}
