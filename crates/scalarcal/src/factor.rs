//! The triangular factor of the rows that were taken.

use faer::Mat;
use serde::{Deserialize, Serialize};

/// Rows of one factorisation.
pub const BLOCK: usize = 512;

/// U upper triangular with UᵀU = DᵀD for all rows D that were taken: square-root information. Two factors are joined by
/// stacking them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Factor {
    rows: u64,
    /// Rows of the upper triangle, each from its diagonal on.
    upper: Vec<Vec<f64>>,
}

impl Factor {
    /// No rows of so many columns.
    pub fn new(columns: usize) -> Self {
        Self { rows: 0, upper: (0..columns).map(|row| vec![0.0; columns - row]).collect() }
    }

    /// Rows taken.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// U as a matrix.
    pub fn upper(&self) -> Mat<f64> {
        let columns = self.upper.len();
        Mat::from_fn(columns, columns, |i, j| if i <= j { self.upper[i][j - i] } else { 0.0 })
    }

    /// UᵀU between two columns.
    pub fn product(&self, a: usize, b: usize) -> f64 {
        (0..=a.min(b)).map(|row| self.upper[row][a - row] * self.upper[row][b - row]).sum()
    }

    /// Takes the first `rows` rows of a block; each column is a slice of at least that length.
    pub fn push(&mut self, columns: &[Vec<f64>], rows: usize) {
        if rows == 0 {
            return;
        }
        let above = self.upper.len();
        let mut stack = Mat::zeros(above + rows, above);
        for (j, column) in columns.iter().enumerate() {
            let stacked = stack.col_as_slice_mut(j);
            (0..=j).for_each(|i| stacked[i] = self.upper[i][j - i]);
            stacked[above..].copy_from_slice(&column[..rows]);
        }
        self.take(&stack, rows as u64);
    }

    /// Takes what another factor has taken.
    pub fn merge(&mut self, other: &Self) {
        let columns = self.upper.len();
        if other.rows == 0 {
            return;
        }
        let stack = Mat::from_fn(2 * columns, columns, |i, j| {
            let (of, row) = if i < columns { (&*self, i) } else { (other, i - columns) };
            if row <= j { of.upper[row][j - row] } else { 0.0 }
        });
        self.take(&stack, other.rows);
    }

    fn take(&mut self, stack: &Mat<f64>, rows: u64) {
        let qr = stack.qr();
        let upper = qr.thin_R();
        for (i, row) in self.upper.iter_mut().enumerate() {
            // The sign of a row is free; a positive diagonal makes the factor unique.
            let sign = if upper[(i, i)] < 0.0 { -1.0 } else { 1.0 };
            row.iter_mut().enumerate().for_each(|(k, value)| *value = sign * upper[(i, i + k)]);
        }
        self.rows += rows;
    }
}
