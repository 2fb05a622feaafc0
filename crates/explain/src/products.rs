//! Products of columns under each form of noise: from here on nothing depends on the number of rows.

use estimate::{add_gram, mirrored};
use faer::Mat;
use rayon::prelude::*;

use crate::noises::Filter;
use crate::stack::Stack;

/// Products of whitened columns, and the determinant of the covariance.
#[derive(Clone, Debug)]
pub struct Product {
    /// Xᵀ C⁻¹ X.
    pub gram: Mat<f64>,
    /// ln |C|, and ln of the prior odds of the noise.
    pub log_determinant: f64,
    pub log_prior: f64,
}

/// Those of a stack's columns under each noise.
pub fn products(stack: &Stack, filters: &[Filter]) -> Vec<Product> {
    let all: Vec<usize> = (0..stack.columns.len()).collect();
    filters.par_iter().map(|filter| product(stack, &all, filter)).collect()
}

/// The same of some of the columns, with zeros for the others.
pub fn product(stack: &Stack, among: &[usize], filter: &Filter) -> Product {
    let columns: Vec<&[f64]> = among.iter().map(|column| stack.columns[*column].as_slice()).collect();
    let mut own = Mat::<f64>::zeros(among.len(), among.len());
    filter.whitening.by_rows(&columns, |some| add_gram(&mut own, some));
    let own = mirrored(own);
    let mut gram = Mat::zeros(stack.columns.len(), stack.columns.len());
    for (i, row) in among.iter().enumerate() {
        among.iter().enumerate().for_each(|(j, column)| gram[(*row, *column)] = own[(i, j)]);
    }
    for (column, known) in &stack.known {
        gram[(*column, *column)] += known;
    }
    let log_prior = filter.form.prior(filter.whitening.rows());
    Product { gram, log_determinant: filter.whitening.log_determinant(), log_prior }
}
