//! Products of columns under each form of noise: from here on nothing depends on the number of rows.

use estimate::{Error, gram_of};
use faer::Mat;
use rayon::prelude::*;

use crate::noises::Form;
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
///
/// # Errors
///
/// Times out of order.
pub fn products(time_s: &[f64], stack: &Stack, noises: &[Form]) -> Result<Vec<Product>, Error> {
    let all: Vec<usize> = (0..stack.columns.len()).collect();
    noises.par_iter().map(|noise| product(time_s, stack, &all, noise)).collect()
}

/// The same of some of the columns, with zeros for the others.
///
/// # Errors
///
/// Times out of order.
pub fn product(time_s: &[f64], stack: &Stack, among: &[usize], noise: &Form) -> Result<Product, Error> {
    let filter = noise.whitening(time_s)?;
    let mut white: Vec<Vec<f64>> = among.iter().map(|column| stack.columns[*column].clone()).collect();
    filter.whiten_all(&mut white);
    let own = gram_of(&white);
    let mut gram = Mat::zeros(stack.columns.len(), stack.columns.len());
    for (i, row) in among.iter().enumerate() {
        among.iter().enumerate().for_each(|(j, column)| gram[(*row, *column)] = own[(i, j)]);
    }
    for (column, known) in &stack.known {
        gram[(*column, *column)] += known;
    }
    Ok(Product { gram, log_determinant: filter.log_determinant(), log_prior: noise.prior(time_s.len()) })
}
