//! Prediction of rows that were left out of the fit.

use faer::Mat;

use super::{Products, Screen};
use crate::Error;

impl Products {
    /// Σ of the squared residuals in each block, with the coefficients of `group` fitted to all other blocks. A coefficient that the
    /// others do not determine is zero.
    ///
    /// # Errors
    ///
    /// [`Error::Decomposition`] for products that are not finite.
    pub fn held_out(&self, group: &[usize]) -> Result<Vec<f64>, Error> {
        let total = self.total();
        let last = self.columns;
        self.blocks
            .iter()
            .map(|block| {
                let left: Mat<f64> = &total - block;
                let whole = (0..last).map(|j| total[(j, j)]).collect();
                let rest = Screen { left, whole, rows: 0, used: 0 };
                let coefficients = rest.gain(group)?.coefficients;
                let linear: f64 = group.iter().zip(&coefficients).map(|(j, a)| a * block[(*j, last)]).sum();
                let square: f64 = group
                    .iter()
                    .zip(&coefficients)
                    .flat_map(|(i, a)| {
                        group.iter().zip(&coefficients).map(move |(j, b)| a * b * block[(*i, *j)])
                    })
                    .sum();
                Ok(block[(last, last)] - 2.0 * linear + square)
            })
            .collect()
    }
}
