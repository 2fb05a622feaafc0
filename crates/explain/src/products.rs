//! Products of columns under each form of noise: from here on nothing depends on the number of rows.

use common::Noise;
use estimate::Error;
use faer::{Mat, Par};
use noise::Whitening;
use rayon::prelude::*;

/// The longest period of noise with memory, in lengths of the recording.
const OLDEST: f64 = 2.0;

/// Products of whitened columns, and the determinant of the covariance.
#[derive(Clone, Debug)]
pub struct Product {
    /// Xᵀ C⁻¹ X.
    pub gram: Mat<f64>,
    /// ln |C|.
    pub log_determinant: f64,
}

/// The filter of a noise at these times.
pub fn whitening(time_s: &[f64], noise: &Noise) -> Result<Whitening, Error> {
    let length = time_s.last().zip(time_s.first()).map_or(0.0, |(last, first)| last - first);
    Whitening::of(noise, Some(time_s), time_s.len(), OLDEST * length)
        .map_err(|_| Error::Series("whose times are not in order, or that no noise is for"))
}

/// Those of the columns under each noise.
///
/// # Errors
///
/// Times out of order.
pub fn products(time_s: &[f64], columns: &[Vec<f64>], noises: &[Noise]) -> Result<Vec<Product>, Error> {
    noises.par_iter().map(|noise| product(time_s, columns, noise)).collect()
}

fn product(time_s: &[f64], columns: &[Vec<f64>], noise: &Noise) -> Result<Product, Error> {
    let filter = whitening(time_s, noise)?;
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
    Ok(Product { gram, log_determinant: filter.log_determinant() })
}
