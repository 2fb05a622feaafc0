//! What a fit and its noise predict of readings that are left out: ten contiguous blocks, each from the others.

use estimate::Error;
use faer::Mat;
use rayon::prelude::*;

use crate::amplitude::Fitted;
use crate::fit::Fit;
use crate::noises::Form;
use crate::problem::Problem;

/// Blocks of rows that are left out in turn.
pub const BLOCKS: usize = 10;

/// Rms of each channel's readings that are left out, by all causes but one: what the columns say of them, and the
/// most likely noise by what is known before and after; the coefficients are those under the noise, or of plain least
/// squares where these predict better.
///
/// # Errors
///
/// Times out of order.
pub fn rms(problem: &Problem, fitted: &Fitted, without: Option<usize>) -> Result<Vec<f64>, Error> {
    (0..fitted.noise.len())
        .into_par_iter()
        .map(|channel| {
            let (columns, known) = fitted.columns_of(channel, without);
            let y = &problem.channels[channel];
            let blocks: Vec<[f64; 2]> = (0..BLOCKS)
                .into_par_iter()
                .map(|block| missed(problem, (&columns, &known), y, &fitted.noise[channel], block))
                .collect::<Result<_, _>>()?;
            let squares = |by: usize| blocks.iter().map(|missed| missed[by]).sum::<f64>();
            Ok((squares(0).min(squares(1)) / problem.rows().max(1) as f64).sqrt())
        })
        .collect()
}

/// Sums of the squares by which a block is missed, with coefficients under the noise and of plain least squares.
fn missed(
    problem: &Problem,
    (columns, known): (&[&[f64]], &[f64]),
    y: &[f64],
    noise: &Form,
    block: usize,
) -> Result<[f64; 2], Error> {
    let rows = problem.rows();
    let (from, to) = (block * rows / BLOCKS, (block + 1) * rows / BLOCKS);
    let others =
        |column: &[f64]| -> Vec<f64> { column[..from].iter().chain(&column[to..]).copied().collect() };
    let times = others(&problem.time_s);
    let filter = noise.whitening(&times)?;
    let mean = estimate::stats::mean(y);
    let centred: Vec<f64> = others(y).iter().map(|value| value - mean).collect();
    let own: Vec<Vec<f64>> = columns.iter().map(|column| others(column)).chain([centred]).collect();
    let mut white = own.clone();
    filter.whiten_all(&mut white);
    let missed = |white: &[Vec<f64>]| {
        let count = white.len();
        let mut gram = Mat::from_fn(count, count, |i, j| estimate::dot(&white[i], &white[j]));
        known.iter().enumerate().for_each(|(column, known)| gram[(column, column)] += known);
        let fit = Fit::of(&gram, count - 1, &(0..count - 1).collect::<Vec<_>>());
        let likely = if filter.is_white() {
            vec![0.0; to - from]
        } else {
            let v = filter.whiten_transposed(&filter.whiten(&fit.rest(&own, &own[count - 1])));
            filter.most_likely(&times, &v, &problem.time_s[from..to])
        };
        let named = |row: usize| -> f64 {
            fit.columns.iter().zip(&fit.coefficients).map(|(column, size)| size * columns[*column][row]).sum()
        };
        (from..to).map(|row| (y[row] - mean - named(row) - likely[row - from]).powi(2)).sum()
    };
    Ok([missed(&white), missed(&own)])
}
