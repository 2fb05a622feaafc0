//! The triangular factor of the rows that were taken, and how many they are.

use common::covariance;
use estimate::triangle::Triangle;
use faer::Mat;
use serde::{Deserialize, Serialize};

/// Rows of one factorisation.
pub const BLOCK: usize = 512;

/// All that rows say of the columns' products.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Factor {
    pub rows: u64,
    triangle: Triangle,
    /// Rows that are not yet in the triangle, one after the other.
    #[serde(skip)]
    waiting: Vec<f64>,
}

impl Factor {
    /// No rows of so many columns.
    pub fn new(columns: usize) -> Self {
        Self { rows: 0, triangle: Triangle::new(columns), waiting: Vec::new() }
    }

    /// Takes a row. What is asked of the factor waits for [`Self::finish`].
    pub fn row(&mut self, values: impl IntoIterator<Item = f64>) {
        self.waiting.extend(values);
        self.rows += 1;
        if self.waiting.len() == BLOCK * self.triangle.columns() {
            self.settle();
        }
    }

    /// With all rows in the triangle.
    pub fn finish(mut self) -> Self {
        self.settle();
        self.waiting = Vec::new();
        self
    }

    fn settle(&mut self) {
        let columns = self.triangle.columns();
        let fill = |j: usize, below: &mut [f64]| {
            below
                .iter_mut()
                .zip(self.waiting[j..].iter().step_by(columns))
                .for_each(|(to, value)| *to = *value);
        };
        self.triangle.take(self.waiting.len() / columns, fill);
        self.waiting.clear();
    }

    /// Of parts, in their order.
    pub fn joined<'a>(columns: usize, parts: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut all = Self::new(columns);
        parts.into_iter().for_each(|part| all.join(part));
        all
    }

    /// Takes what another factor has taken.
    pub fn join(&mut self, other: &Self) {
        let columns = self.triangle.columns();
        let waiting = other.waiting.chunks_exact(columns);
        let settled = other.rows - waiting.len() as u64;
        if self.rows == (self.waiting.len() / columns) as u64 {
            self.triangle.clone_from(&other.triangle);
        } else if settled > 0 {
            let fill = |j: usize, below: &mut [f64]| {
                (0..=j).for_each(|i| below[i] = other.triangle.at(i, j));
            };
            self.triangle.take(columns, fill);
        }
        self.rows += settled;
        waiting.for_each(|row| self.row(row.iter().copied()));
    }

    /// The same rows with each column times a factor.
    pub fn scaled(&self, by: &[f64]) -> Self {
        Self { rows: self.rows, triangle: self.triangle.scaled(by), waiting: Vec::new() }
    }

    /// Whether it is a factor of so many columns of finite numbers, after reading it from outside.
    pub fn is_whole(&self, columns: usize) -> bool {
        self.rows > 0
            && self.triangle.is_whole(columns)
            && (0..columns).all(|j| (0..=j).all(|i| self.triangle.at(i, j).is_finite()))
    }

    pub fn upper(&self) -> Mat<f64> {
        self.triangle.upper()
    }

    /// UᵀU between two columns.
    pub fn product(&self, a: usize, b: usize) -> f64 {
        self.triangle.product(a, b)
    }
}

/// Rows as they are, or where they are more than their columns as the rows of their factor.
pub fn compressed(rows: Vec<Vec<f64>>, columns: usize) -> Vec<Vec<f64>> {
    if rows.len() <= columns {
        return rows;
    }
    let mut factor = Factor::new(columns);
    rows.into_iter().for_each(|row| factor.row(row));
    covariance::rows(&factor.finish().upper())
}
