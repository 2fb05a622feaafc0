//! Noise of the readings that the others are regressed on.
//!
//! Of a regressor X = B + ν the products hold the noise too: XᵀX = BᵀB + σ² NᵀN, N what noise of one nT makes of the
//! columns. It pulls their coefficients toward zero, and what is then left of the field a column that resembles the
//! field may make up for; such a column may even predict the noise of the readings, where it shows the field better
//! than they do. So each name is weighed once more with the answer to the field held at what it is without that noise.
//! How large σ is cannot be seen in the difference: σ² is a share of the white part of what is left, and at most what
//! the readings themselves have at the shortest periods.
//!
//! Source: W. A. Fuller, Measurement Error Models, Wiley 1987, section 2.2.

use crate::fit::Fit;
use crate::problem::Problem;
use crate::stack::{Named, Product, Stack};

/// So many shares are tried, to all.
pub const SHARES: u32 = 10;
/// Of the readings' own products no more than this share may be noise, beside all other columns: beyond, the field
/// is not seen.
const MOST: f64 = 0.9;
/// Sum of the squares of the third difference's coefficients.
const THIRD: f64 = 20.0;
/// The median of the square of a normal number.
const MEDIAN: f64 = 0.455;

/// The largest variance of the noise of each reading, by third differences, nT². The median is not moved by single
/// spikes.
fn largest(problem: &Problem) -> Vec<f64> {
    let of = |column: &Vec<f64>| {
        let third = |w: &[f64]| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2);
        let mut squares: Vec<f64> = column.windows(4).map(third).collect();
        if squares.is_empty() { 0.0 } else { estimate::stats::median_of(&mut squares) / (MEDIAN * THIRD) }
    };
    problem.base.iter().take(problem.noisy).map(of).collect()
}

/// The products of a channel's readings less their answer to the field, as white noise has it beside a set at some
/// share: that noise is taken out of the readings' products. The first of the products is of white noise.
pub fn held(
    problem: &Problem,
    stack: &Stack,
    made: &[Product],
    (channel, set): (usize, &[Named]),
    share: f64,
) -> Vec<Product> {
    let (y, white, rows) = (stack.y[channel], &made[0], stack.rows());
    // A column that resembles the field takes noise of the reference away: beside the base alone it is all there.
    let left = Fit::of(&white.gram, y, &stack.base).left / rows as f64 * stack.scale[y] * stack.scale[y];
    let noise: Vec<f64> = largest(problem).into_iter().map(|own| own.min(left)).collect();
    let mut columns = [&stack.base[..], &stack.shown(set, channel)].concat();
    if hidden(stack, white, &noise, &columns) > MOST {
        // Names that are the field itself do not say how the instrument answers to it.
        columns.truncate(stack.base.len());
    }
    let seen = (MOST / hidden(stack, white, &noise, &columns)).min(1.0);
    let mut gram = white.gram.clone();
    for (reading, noise) in noise.iter().enumerate() {
        let (column, by) = added(stack, white, reading);
        gram[(column, column)] -= share * seen * noise * by;
    }
    let fit = Fit::of(&gram, y, &columns);
    let answer: Vec<(usize, f64)> =
        stack.base[..problem.noisy].iter().map(|column| (*column, fit.coefficient(*column))).collect();
    let mut all = made.to_vec();
    for Product { gram, .. } in &mut all {
        // Row and column of y − Σ m x.
        for other in 0..gram.ncols() {
            gram[(y, other)] -= answer.iter().map(|(x, m)| m * gram[(*x, other)]).sum::<f64>();
        }
        for other in 0..gram.ncols() {
            gram[(other, y)] -= answer.iter().map(|(x, m)| m * gram[(other, *x)]).sum::<f64>();
        }
    }
    all
}

/// The column of a reading, and what each nT² of its noise adds to the column's square.
fn added(stack: &Stack, product: &Product, reading: usize) -> (usize, f64) {
    let (column, noise) = (stack.base[reading], stack.noise[reading]);
    (column, product.gram[(noise, noise)] / (stack.scale[column] * stack.scale[column]))
}

/// The share of noise in what other columns leave of the readings: the largest in any direction is at most this sum.
fn hidden(stack: &Stack, product: &Product, noise: &[f64], columns: &[usize]) -> f64 {
    let fit = Fit::of(&product.gram, stack.base[0], columns);
    let share = |(reading, noise): (usize, &f64)| {
        let (column, by) = added(stack, product, reading);
        fit.place(column).map_or(0.0, |place| noise * by * fit.inverse[(place, place)])
    };
    noise.iter().enumerate().map(share).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    /// A column follows the field and nothing else; the reference is noisy. Corrected at some share, nothing is left
    /// for it.
    #[test]
    fn a_column_that_resembles_the_field_is_none() {
        let rows = 2000;
        let mut stream = noise::Stream::new(3, "reference");
        let mut level = 0.0;
        let field: Vec<f64> = (0..rows)
            .map(|_| {
                level += 0.02 * stream.normal();
                level
            })
            .collect();
        let mut noisy =
            |size: f64| -> Vec<f64> { field.iter().map(|b| b + size * stream.normal()).collect() };
        let (test, reference, column) = (noisy(0.1), noisy(0.3), noisy(1.0));
        let time_s: Vec<f64> = (0..rows).map(f64::from).collect();
        let gram =
            |all: &[Vec<f64>]| Mat::from_fn(all.len(), all.len(), |i, j| estimate::dot(&all[i], &all[j]));
        let plain = Fit::of(&gram(&[reference.clone(), column.clone(), test.clone()]), 2, &[0, 1]);
        assert!(plain.coefficient(1) > 0.02, "{plain:?}");
        let covariate = crate::Covariate { name: "x_v".into(), time_s: time_s.clone(), values: column };
        let problem = Problem {
            time_s,
            channels: vec![test],
            base: vec![reference],
            noisy: 1,
            covariates: vec![covariate],
            ..Problem::default()
        };
        let found = crate::explain(&problem, &|_| ()).expect("explained");
        assert!(found.causes.is_empty(), "{:?}", found.causes);
    }
}
