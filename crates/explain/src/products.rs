//! Products of columns under each form of noise: from here on nothing depends on the number of rows.

use estimate::Error;
use faer::{Mat, Par};
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
    noises.par_iter().map(|noise| product(time_s, stack, noise)).collect()
}

fn product(time_s: &[f64], stack: &Stack, noise: &Form) -> Result<Product, Error> {
    let columns = &stack.columns;
    let filter = noise.whitening(time_s)?;
    let mut white = columns.to_vec();
    filter.whiten_all(&mut white);
    let rows = time_s.len();
    let matrix = Mat::from_fn(rows, columns.len(), |row, column| white[column][row]);
    drop(white);
    let mut gram = Mat::zeros(columns.len(), columns.len());
    faer::linalg::matmul::matmul(
        gram.as_mut(),
        faer::Accum::Replace,
        matrix.transpose(),
        matrix.as_ref(),
        1.0,
        Par::Seq,
    );
    for (column, known) in &stack.known {
        gram[(*column, *column)] += known;
    }
    Ok(Product { gram, log_determinant: filter.log_determinant(), log_prior: noise.prior(rows) })
}
