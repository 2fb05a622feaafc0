//! Fits to all but a block of rows.

use faer::Mat;

use super::{Products, Screen};
use crate::Error;

impl Products {
    /// For each block the coefficients of `group` fitted to all other blocks. One that the others do not determine is zero.
    ///
    /// # Errors
    ///
    /// [`Error::Decomposition`] for products that are not finite.
    pub fn left_out(&self, group: &[usize]) -> Result<Vec<Vec<f64>>, Error> {
        let total = self.total();
        let whole: Vec<f64> = (0..self.columns).map(|j| total[(j, j)]).collect();
        let without = |block| {
            let left: Mat<f64> = &total - block;
            let rest = Screen { left, whole: whole.clone(), rows: 0, used: 0 };
            Ok(rest.gain(group)?.coefficients)
        };
        self.blocks.iter().map(without).collect()
    }
}
