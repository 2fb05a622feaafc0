//! A triangular factor that takes rows without end: square-root information.

use faer::Mat;
use serde::{Deserialize, Serialize};

/// U upper triangular with UᵀU = DᵀD for all rows D that were taken. Two factors are joined by stacking them.
///
/// Source: J. Demmel, L. Grigori, M. Hoemmen, J. Langou, Communication-optimal parallel and sequential QR and LU
/// factorizations, SIAM J. Sci. Comput. 34 (2012) A206–A239.
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

    /// Takes so many rows; `fill` writes those of a column.
    pub fn take(&mut self, rows: usize, fill: impl Fn(usize, &mut [f64])) {
        let columns = self.columns();
        let mut stack = Mat::zeros(columns + rows, columns);
        for j in 0..columns {
            let column = stack.col_as_slice_mut(j);
            (0..=j).for_each(|i| column[i] = self.0[i][j - i]);
            fill(j, &mut column[columns..]);
        }
        let qr = stack.qr();
        let upper = qr.thin_R();
        for (i, row) in self.0.iter_mut().enumerate() {
            row.iter_mut().enumerate().for_each(|(k, value)| *value = upper[(i, i + k)]);
        }
    }
}
