//! What a fit and its noise predict of readings that are left out: ten contiguous blocks, each from the others.

use estimate::Error;
use rayon::prelude::*;

use crate::amplitude::Fitted;
use crate::fit::Fit;
use crate::problem::Problem;

/// Blocks of rows that are left out in turn.
pub const BLOCKS: usize = 10;

/// Rms of each channel's readings that are left out, for each entry of `without`: by all causes but that one, or by
/// all for `None`. A prediction is what the columns give and the most likely noise, given the readings before and
/// after; the coefficients are those under the noise, or of plain least squares where these predict better.
///
/// # Errors
///
/// Times out of order.
pub fn rms(problem: &Problem, fitted: &Fitted, without: &[Option<usize>]) -> Result<Vec<Vec<f64>>, Error> {
    let of_channel = |channel: usize| -> Result<Vec<f64>, Error> {
        let sets: Vec<Vec<usize>> = without.iter().map(|cause| fitted.without(channel, *cause)).collect();
        // Without a cause that does not show in the channel the columns are the same.
        let mut distinct = sets.clone();
        distinct.sort_unstable();
        distinct.dedup();
        let blocks: Vec<Vec<[f64; 2]>> = (0..BLOCKS)
            .into_par_iter()
            .map(|block| missed(problem, fitted, channel, block, &distinct))
            .collect::<Result<_, _>>()?;
        let rms = |set: &Vec<usize>| {
            let place = distinct.partition_point(|other| other < set);
            let squares = |by: usize| blocks.iter().map(|missed| missed[place][by]).sum::<f64>();
            (squares(0).min(squares(1)) / problem.rows().max(1) as f64).sqrt()
        };
        Ok(sets.iter().map(rms).collect())
    };
    let of_channels: Vec<Vec<f64>> =
        (0..fitted.noise.len()).into_par_iter().map(of_channel).collect::<Result<_, _>>()?;
    Ok((0..without.len()).map(|set| of_channels.iter().map(|rms| rms[set]).collect()).collect())
}

/// Sums of the squares by which a block is missed with each set of columns, with coefficients under the noise and of
/// plain least squares.
fn missed(
    problem: &Problem,
    fitted: &Fitted,
    channel: usize,
    block: usize,
    sets: &[Vec<usize>],
) -> Result<Vec<[f64; 2]>, Error> {
    let (columns, known) = fitted.columns_of(channel);
    let y = &problem.channels[channel];
    let rows = problem.rows();
    let (from, to) = (block * rows / BLOCKS, (block + 1) * rows / BLOCKS);
    let others =
        |column: &[f64]| -> Vec<f64> { column[..from].iter().chain(&column[to..]).copied().collect() };
    let times = others(&problem.time_s);
    let filter = fitted.noise[channel].whitening(&times)?;
    let mean = estimate::stats::mean(y);
    let centred: Vec<f64> = others(y).iter().map(|value| value - mean).collect();
    let own: Vec<Vec<f64>> = columns.iter().map(|column| others(column)).chain([centred]).collect();
    let products = |columns: &[Vec<f64>]| {
        let mut gram = estimate::gram_of(columns);
        known.iter().enumerate().for_each(|(column, known)| gram[(column, column)] += known);
        gram
    };
    let plain = products(&own);
    let mut white = own;
    filter.whiten_all(&mut white);
    let under_noise = products(&white);
    // Each set under the noise, then by plain least squares.
    let grams = [&under_noise, &plain];
    let fits: Vec<Fit> =
        sets.iter().flat_map(|set| grams.map(|gram| Fit::of(gram, columns.len(), set))).collect();
    let likely = if filter.is_white() {
        vec![vec![0.0; to - from]; fits.len()]
    } else {
        let mut rests: Vec<Vec<f64>> =
            fits.iter().map(|fit| fit.rest(&white, &white[columns.len()])).collect();
        filter.whiten_transposed_all(&mut rests);
        filter.most_likely(&times, &rests, &problem.time_s[from..to])
    };
    let missed = |(fit, likely): (&Fit, Vec<f64>)| -> f64 {
        let named = |row: usize| -> f64 {
            fit.columns.iter().zip(&fit.coefficients).map(|(column, size)| size * columns[*column][row]).sum()
        };
        (from..to).zip(likely).map(|(row, likely)| (y[row] - mean - named(row) - likely).powi(2)).sum()
    };
    let squares: Vec<f64> = fits.iter().zip(likely).map(missed).collect();
    Ok(squares.as_chunks().0.to_vec())
}
