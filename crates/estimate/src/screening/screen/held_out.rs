//! Fits to all but a block of rows.

use faer::Mat;

use super::products::Products;
use super::projection::Screen;
use crate::Error;

impl Products {
    /// For each block the coefficients of `group` fitted to all other blocks. One that the others do not
    /// determine is zero.
    ///
    /// # Errors
    ///
    /// [`Error::Decomposition`] for products that are not finite.
    pub fn left_out(&self, group: &[usize]) -> Result<Vec<Vec<f64>>, Error> {
        let total = self.total();
        let without = |block| {
            let left: Mat<f64> = &total - block;
            Ok(Screen::of_products(self.columns, left.as_ref(), 0).gain(group)?.coefficients)
        };
        self.blocks.iter().map(without).collect()
    }
}
