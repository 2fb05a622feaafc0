//! The triangular factor of the rows that were taken, and how many they are.

use estimate::triangle::Triangle;
use faer::Mat;
use serde::{Deserialize, Serialize};

/// Rows of one factorisation.
pub const BLOCK: usize = 512;

/// All that rows say of the columns' products.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Factor {
    rows: u64,
    triangle: Triangle,
}

impl Factor {
    /// No rows of so many columns.
    pub fn new(columns: usize) -> Self {
        Self { rows: 0, triangle: Triangle::new(columns) }
    }

    /// Of parts, in their order.
    pub fn joined<'a>(columns: usize, parts: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut all = Self::new(columns);
        parts.into_iter().for_each(|part| all.join(part));
        all
    }

    /// Takes what another factor has taken.
    pub fn join(&mut self, other: &Self) {
        if self.rows == 0 {
            self.clone_from(other);
        } else if other.rows > 0 {
            let fill = |j: usize, below: &mut [f64]| {
                (0..=j).for_each(|i| below[i] = other.triangle.at(i, j));
            };
            self.triangle.take(self.triangle.columns(), fill);
            self.rows += other.rows;
        }
    }

    /// The same rows with each column times a factor.
    pub fn scaled(&self, by: &[f64]) -> Self {
        Self { rows: self.rows, triangle: self.triangle.scaled(by) }
    }

    /// Whether it is a factor of so many columns of finite numbers, after reading it from outside.
    pub fn is_whole(&self, columns: usize) -> bool {
        self.rows > 0
            && self.triangle.is_whole(columns)
            && (0..columns).all(|j| (0..=j).all(|i| self.triangle.at(i, j).is_finite()))
    }

    /// Rows taken.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// U as a matrix.
    pub fn upper(&self) -> Mat<f64> {
        self.triangle.upper()
    }

    /// UᵀU between two columns.
    pub fn product(&self, a: usize, b: usize) -> f64 {
        self.triangle.product(a, b)
    }
}

/// Takes rows one by one into a factor, a block at a time.
pub struct Filling {
    factor: Factor,
    columns: usize,
    /// Column by column, each with room for a block.
    block: Vec<f64>,
    /// Rows of the block.
    rows: usize,
}

impl Filling {
    /// No rows of so many columns.
    pub fn new(columns: usize) -> Self {
        Self { factor: Factor::new(columns), columns, block: vec![0.0; columns * BLOCK], rows: 0 }
    }

    /// Takes a row.
    pub fn row(&mut self, values: impl IntoIterator<Item = f64>) {
        let places = self.block.iter_mut().skip(self.rows).step_by(BLOCK);
        places.zip(values).for_each(|(place, value)| *place = value);
        self.rows += 1;
        if self.rows == BLOCK {
            self.flush();
        }
    }

    /// Takes the rows of another.
    pub fn take(&mut self, other: Self) {
        self.factor.join(&other.factor);
        for row in 0..other.rows {
            self.row((0..self.columns).map(|column| other.block[column * BLOCK + row]));
        }
    }

    fn flush(&mut self) {
        let rows = self.rows;
        if rows > 0 {
            let of = |j: usize| &self.block[j * BLOCK..j * BLOCK + rows];
            self.factor.triangle.take(rows, |j, below| below.copy_from_slice(of(j)));
            self.factor.rows += rows as u64;
            self.rows = 0;
        }
    }

    /// The factor of all rows.
    pub fn finish(mut self) -> Factor {
        self.flush();
        self.factor
    }
}
