//! Noise of the readings that the others are regressed on.
//!
//! Of a regressor X = B + ν the products hold the noise too: XᵀC⁻¹X = BᵀC⁻¹B + σ_ν² tr C⁻¹. It pulls the
//! coefficients toward zero, and what is then left of the field a slow column may make up for. How large σ_ν is
//! cannot be seen in the difference: it is a share of the white part of what is left, and at most what the
//! readings themselves have at the shortest periods.
//!
//! Source: W. A. Fuller, Measurement Error Models, Wiley 1987, section 2.2.

use estimate::svd::Svd;
use faer::Mat;

use crate::fit::Fit;
use crate::problem::Problem;
use crate::products::Product;
use crate::search::Named;
use crate::stack::{Shadow, Stack};
use crate::sweep::Sweep;

/// Shares of the white part that are tried, of the largest possible.
const SHARES: [f64; 4] = [0.0, 0.33, 0.67, 1.0];
/// Of the readings' own products no more than this share may be noise in any direction: beyond, the field is
/// not seen at all.
const MOST: f64 = 0.8;
/// Sum of the squares of the third difference's coefficients.
const THIRD: f64 = 20.0;

/// The largest variance of noise of each of the base's readings, by their third differences, nT².
fn largest(problem: &Problem) -> Vec<f64> {
    let of = |column: &Vec<f64>| {
        let mut squares: Vec<f64> =
            column.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2)).collect();
        // By the median, which single spikes do not move: 0.455 of the mean of squares of normal numbers.
        if squares.is_empty() { 0.0 } else { estimate::stats::median_of(&mut squares) / 0.455 / THIRD }
    };
    problem.base.iter().take(problem.noisy).map(of).collect()
}

/// The products of each channel, corrected for some shares.
pub struct Shares<'a> {
    made: &'a [Product],
    stack: &'a Stack,
    rows: usize,
    channels: Vec<Channel>,
}

/// A channel beside the set, under each form of noise.
struct Channel {
    columns: Vec<usize>,
    /// The sum of squares that is left.
    left: Vec<f64>,
    /// Variance of the noise of each reading at the largest share, nT².
    noise: Vec<Vec<f64>>,
}

impl<'a> Shares<'a> {
    /// Of a set beside which the white part is read off.
    pub fn of(problem: &Problem, stack: &'a Stack, made: &'a [Product], set: &[Named]) -> Self {
        let (own, rows) = (largest(problem), problem.rows());
        let of_channel = |channel: usize| {
            let columns: Vec<usize> =
                set.iter().flat_map(|one| stack.candidates[one.candidate].columns[channel].clone()).collect();
            let left = Sweep::of(made, rows, stack.y[channel], &stack.base, &columns).left();
            let scale = stack.scale[stack.y[channel]];
            let of = |(product, left): (&Product, &f64)| {
                let white = left / rows as f64 * scale * scale;
                let bound: Vec<f64> = own.iter().map(|own| own.min(white)).collect();
                let seen = visible(stack, product, &bound);
                bound.iter().map(|variance| variance * seen).collect()
            };
            let noise = made.iter().zip(&left).map(of).collect();
            Channel { columns, left, noise }
        };
        Self { made, stack, rows, channels: (0..stack.y.len()).map(of_channel).collect() }
    }

    /// The products of each channel at each share that is tried; only the first where no reading has noise.
    pub fn each(&self) -> impl Iterator<Item = Vec<Vec<Product>>> + '_ {
        let shares = if self.stack.shadows.is_empty() { &SHARES[..1] } else { &SHARES[..] };
        shares.iter().map(|share| (0..self.channels.len()).map(|of| self.corrected(of, *share)).collect())
    }

    /// What the noise adds to the readings' squares is taken out of them. It is in the difference all the same:
    /// what is left keeps its size.
    fn corrected(&self, number: usize, share: f64) -> Vec<Product> {
        let (channel, y) = (&self.channels[number], self.stack.y[number]);
        let mut all = self.made.to_vec();
        for (product, noise) in all.iter_mut().zip(&channel.noise) {
            for a in &self.stack.shadows {
                for b in self.stack.shadows.iter().filter(|b| b.reading == a.reading) {
                    let by = added(self.stack, product, a, b);
                    product.gram[(a.column, b.column)] -= share * noise[a.reading] * by;
                }
            }
        }
        let left = Sweep::of(&all, self.rows, y, &self.stack.base, &channel.columns).left();
        for ((product, before), after) in all.iter_mut().zip(&channel.left).zip(left) {
            product.gram[(y, y)] += before - after;
        }
        all
    }
}

/// What each nT² of a reading's noise adds to the product of two columns that hold it.
fn added(stack: &Stack, product: &Product, a: &Shadow, b: &Shadow) -> f64 {
    product.gram[(a.noise, b.noise)] / (stack.scale[a.column] * stack.scale[b.column])
}

/// By how much the noise has to be smaller, so that in every direction the readings hold more than noise.
fn visible(stack: &Stack, product: &Product, noise: &[f64]) -> f64 {
    let own: Vec<&Shadow> = stack.shadows.iter().filter(|one| stack.base.contains(&one.column)).collect();
    let columns: Vec<usize> = own.iter().map(|one| one.column).collect();
    let others: Vec<usize> = stack.base.iter().copied().filter(|column| !columns.contains(column)).collect();
    let order: Vec<usize> = others.iter().chain(&columns).copied().collect();
    let Some(last) = order.last() else { return 1.0 };
    let fit = Fit::of(&product.gram, *last, &order);
    let size = |one: &Shadow| (noise[one.reading] * added(stack, product, one, one)).sqrt();
    // The largest eigenvalue of G^-½ D G^-½ is that of D^½ G⁻¹ D^½.
    let share =
        Mat::from_fn(own.len(), own.len(), |i, j| match (fit.place(columns[i]), fit.place(columns[j])) {
            (Some(a), Some(b)) => size(own[i]) * fit.inverse[(a, b)] * size(own[j]),
            _ => 0.0,
        });
    let largest = Svd::of(share.as_ref(), 0.0).map_or(0.0, |svd| svd.sigma().first().copied().unwrap_or(0.0));
    if largest > MOST { MOST / largest } else { 1.0 }
}
