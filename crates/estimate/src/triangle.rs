//! A triangular factor that takes rows without end: square-root information.

use faer::Mat;
use serde::{Deserialize, Serialize};

use crate::linear::dot;

/// Squares below this are what rounding leaves of rounding; their inverse would not be finite.
const NOTHING: f64 = 1e-280;

/// U upper triangular with UᵀU = DᵀD for all rows D that were taken. Two factors are joined by stacking them.
///
/// Source: J. Demmel, L. Grigori, M. Hoemmen, J. Langou, Communication-optimal parallel and sequential QR and
/// LU factorizations, SIAM J. Sci. Comput. 34 (2012) A206–A239.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Triangle(Vec<Vec<f64>>);

impl Triangle {
    /// No rows of so many columns.
    pub fn new(columns: usize) -> Self {
        Self((0..columns).map(|row| vec![0.0; columns - row]).collect())
    }

    /// How many columns it has.
    pub fn columns(&self) -> usize {
        self.0.len()
    }

    /// Whether it is a triangle of so many columns, after reading it from outside.
    pub fn is_whole(&self, columns: usize) -> bool {
        self.columns() == columns
            && self.0.iter().enumerate().all(|(row, upper)| upper.len() + row == columns)
    }

    /// An element of U.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        if i <= j { self.0[i][j - i] } else { 0.0 }
    }

    /// U as a matrix.
    pub fn upper(&self) -> Mat<f64> {
        Mat::from_fn(self.columns(), self.columns(), |i, j| self.at(i, j))
    }

    /// UᵀU between two columns.
    pub fn product(&self, a: usize, b: usize) -> f64 {
        (0..=a.min(b)).map(|row| self.at(row, a) * self.at(row, b)).sum()
    }

    /// The same rows with each column times a factor.
    pub fn scaled(&self, by: &[f64]) -> Self {
        let of = |(i, upper): (usize, &Vec<f64>)| {
            upper.iter().zip(&by[i..]).map(|(value, factor)| value * factor).collect()
        };
        Self(self.0.iter().enumerate().map(of).collect())
    }

    /// Takes so many rows; `fill` writes those of a column.
    ///
    /// Householder's reflections, of which each column's changes one element of U and the rows.
    pub fn take(&mut self, rows: usize, fill: impl Fn(usize, &mut [f64])) {
        let columns = self.columns();
        let mut below = vec![0.0; rows * columns];
        below.chunks_exact_mut(rows.max(1)).enumerate().for_each(|(j, column)| fill(j, column));
        for k in 0..columns {
            let (first, rest) = below[k * rows..].split_at_mut(rows);
            let upper = &mut self.0[k];
            let head = upper[0];
            let square = dot(first, first);
            if square == 0.0 || head * head + square < NOTHING {
                continue;
            }
            let length = (head * head + square).sqrt();
            // Away from zero, so that nothing cancels.
            let top = if head > 0.0 { head + length } else { head - length };
            let scale = 2.0 / (top * top + square);
            upper[0] = head - scale * top * (top * head + square);
            for (j, column) in rest.chunks_exact_mut(rows).enumerate() {
                let along = scale * (top * upper[1 + j] + dot(first, column));
                upper[1 + j] -= along * top;
                column.iter_mut().zip(&*first).for_each(|(value, reflected)| *value -= along * reflected);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_row_again_and_again() {
        let row = [3.0, 1e-4, 7e5, 0.1, 2.0];
        let mut triangle = Triangle::new(5);
        (0..50).for_each(|_| triangle.take(1, |j, below| below[0] = row[j]));
        for i in 0..5 {
            for j in 0..5 {
                let expected = 50.0 * row[i] * row[j];
                assert!((triangle.product(i, j) / expected - 1.0).abs() < 1e-13, "{i} {j}");
            }
        }
    }
}
