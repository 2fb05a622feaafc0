//! Products of columns, gathered block by block.

use faer::{Mat, MatRef};

/// Products of columns and residual, block by block.
#[derive(Clone, Debug)]
pub struct Products {
    pub(super) columns: usize,
    pub(super) blocks: Vec<Mat<f64>>,
    pub(super) rows: Vec<usize>,
}

impl Products {
    /// Of so many columns, none yet.
    pub fn of(columns: usize) -> Self {
        Self { columns, blocks: Vec::new(), rows: Vec::new() }
    }

    /// Adds a block of rows: the columns, then the residual as the last one.
    pub fn push(&mut self, block: MatRef<'_, f64>) {
        self.blocks.push(crate::gram(block));
        self.rows.push(block.nrows());
    }

    /// Adds the blocks of others, behind its own.
    pub fn join(&mut self, others: Products) {
        self.blocks.extend(others.blocks);
        self.rows.extend(others.rows);
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows.iter().sum()
    }

    /// Sum over the blocks.
    pub(super) fn total(&self) -> Mat<f64> {
        let zero = Mat::zeros(self.columns + 1, self.columns + 1);
        self.blocks.iter().fold(zero, |sum, block| sum + block)
    }
}
