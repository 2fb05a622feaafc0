//! Linear least squares: dense, correlated, in one pass over rows without end, and what is read off a fit.

pub mod correlated;
pub mod exact;
pub mod hac;
pub mod influence;
mod least_squares;
pub mod mixture;
pub mod positive;
pub mod svd;
pub mod triangle;
pub mod tsqr;
pub mod wander;

pub use least_squares::{LinearFit, fit};

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, MatRef, Par};

/// Rows of which products are gathered at a time.
const ROWS: usize = 1024;

/// AᵀA.
pub fn gram(a: MatRef<'_, f64>) -> Mat<f64> {
    let mut gram = Mat::zeros(a.ncols(), a.ncols());
    add_lower(&mut gram, a);
    mirrored(gram)
}

/// Adds AᵀA of further rows, given column after column, to the lower triangle of `sum`; [`mirrored`] completes it.
pub fn add_gram(sum: &mut Mat<f64>, columns: &[f64]) {
    let count = sum.ncols();
    if let Some(rows) = columns.len().checked_div(count) {
        add_lower(sum, MatRef::from_column_major_slice(columns, rows, count));
    }
}

/// AᵀA of the columns of A, by blocks of rows.
pub fn gram_of<C: AsRef<[f64]>>(columns: &[C]) -> Mat<f64> {
    let (rows, count) = (columns.first().map_or(0, |column| column.as_ref().len()), columns.len());
    let mut gram = Mat::zeros(count, count);
    let mut part = Mat::zeros(ROWS.min(rows), count);
    for from in (0..rows).step_by(ROWS) {
        let some = ROWS.min(rows - from);
        for (number, column) in columns.iter().enumerate() {
            part.col_as_slice_mut(number)[..some].copy_from_slice(&column.as_ref()[from..from + some]);
        }
        add_lower(&mut gram, part.subrows(0, some));
    }
    mirrored(gram)
}

fn add_lower(gram: &mut Mat<f64>, a: MatRef<'_, f64>) {
    let (lower, whole) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
    matmul(gram.as_mut(), lower, Accum::Add, a.transpose(), whole, a, whole, 1.0, Par::Seq);
}

/// Completes a symmetric matrix from its lower triangle.
pub fn mirrored(mut gram: Mat<f64>) -> Mat<f64> {
    for j in 0..gram.ncols() {
        (0..j).for_each(|i| gram[(i, j)] = gram[(j, i)]);
    }
    gram
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
