//! The triangular factor of the rows that were taken, and how many they are.

use estimate::triangle::Triangle;
use faer::Mat;

/// Rows of one factorisation.
pub const BLOCK: usize = 512;

/// All that rows say of the columns' products.
#[derive(Clone, Debug, PartialEq)]
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
        for part in parts.into_iter().filter(|part| part.rows > 0) {
            all.triangle.take(columns, |j, below| (0..=j).for_each(|i| below[i] = part.triangle.at(i, j)));
            all.rows += part.rows;
        }
        all
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
    block: Vec<Vec<f64>>,
}

impl Filling {
    /// No rows of so many columns.
    pub fn new(columns: usize) -> Self {
        Self { factor: Factor::new(columns), block: vec![Vec::with_capacity(BLOCK); columns] }
    }

    /// Takes a row.
    pub fn row(&mut self, values: impl IntoIterator<Item = f64>) {
        self.block.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        if self.block[0].len() == BLOCK {
            self.flush();
        }
    }

    fn flush(&mut self) {
        let rows = self.block[0].len();
        if rows > 0 {
            self.factor.triangle.take(rows, |j, below| below.copy_from_slice(&self.block[j]));
            self.factor.rows += rows as u64;
            self.block.iter_mut().for_each(Vec::clear);
        }
    }

    /// The factor of all rows.
    pub fn finish(mut self) -> Factor {
        self.flush();
        self.factor
    }
}
