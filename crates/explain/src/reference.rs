//! Noise of the readings that the others are regressed on.
//!
//! Of a regressor X = B + ν the products hold the noise too: XᵀC⁻¹X = BᵀC⁻¹B + σ² NᵀC⁻¹N, N what noise of one nT makes
//! of the columns. It pulls their coefficients toward zero, and what is then left of the field a column that
//! resembles the field may make up for. How large σ is cannot be seen in the difference: σ² is a share of the white
//! part of what is left, and at most what the readings themselves have at the shortest periods.
//!
//! Source: W. A. Fuller, Measurement Error Models, Wiley 1987, section 2.2.

use crate::fit::Fit;
use crate::problem::Problem;
use crate::products::Product;
use crate::search::Named;
use crate::stack::Stack;
use crate::sweep::Sweep;

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

/// The products as a channel has them at some share: what the noise adds to the readings' products is taken out.
/// It is in the difference all the same: what is left beside the whole set keeps its size.
pub fn corrected(
    problem: &Problem,
    stack: &Stack,
    made: &[Product],
    (channel, set): (usize, &[Named]),
    share: f64,
) -> Vec<Product> {
    let (own, y, rows) = (largest(problem), stack.y[channel], problem.rows());
    let columns: Vec<usize> =
        set.iter().flat_map(|one| stack.candidates[one.candidate].columns[channel].clone()).collect();
    let before = Sweep::of(made, rows, y, &stack.base, &columns).left();
    // A column that resembles the field takes noise of the reference away: beside the base alone it is all there.
    let alone = Sweep::of(made, rows, y, &stack.base, &[]).left();
    let mut all = made.to_vec();
    for (product, left) in all.iter_mut().zip(&alone) {
        let white = left / rows as f64 * stack.scale[y] * stack.scale[y];
        let noise: Vec<f64> = own.iter().map(|own| own.min(white)).collect();
        let seen = visible(stack, product, &noise);
        for (reading, noise) in noise.iter().enumerate() {
            let (column, by) = added(stack, product, reading);
            product.gram[(column, column)] -= share * seen * noise * by;
        }
    }
    let after = Sweep::of(&all, rows, y, &stack.base, &columns).left();
    for ((product, before), after) in all.iter_mut().zip(&before).zip(after) {
        product.gram[(y, y)] += before - after;
    }
    all
}

/// The column of a reading, and what each nT² of its noise adds to the column's square.
fn added(stack: &Stack, product: &Product, reading: usize) -> (usize, f64) {
    let (column, noise) = (stack.base[reading], stack.noise[reading]);
    (column, product.gram[(noise, noise)] / (stack.scale[column] * stack.scale[column]))
}

/// By how much the noise has to be smaller, so that the readings hold more than noise.
fn visible(stack: &Stack, product: &Product, noise: &[f64]) -> f64 {
    let fit = Fit::of(&product.gram, stack.base[0], &stack.base);
    let share = |(reading, noise): (usize, &f64)| {
        let (column, by) = added(stack, product, reading);
        fit.place(column).map_or(0.0, |place| noise * by * fit.inverse[(place, place)])
    };
    // The largest share in any direction is at most their sum.
    let sum: f64 = noise.iter().enumerate().map(share).sum();
    if sum > MOST { MOST / sum } else { 1.0 }
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
