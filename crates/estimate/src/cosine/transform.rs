//! The transform.

use std::f64::consts::PI;
use std::ops::Range;

use crate::stats::mean;

/// The cosine transform of series of n samples Δt apart.
#[derive(Clone)]
pub struct Cosine {
    pub(super) rows: usize,
    pub(super) step_s: f64,
    plan: fourier::Cosine,
}

impl Cosine {
    /// For series of `rows` samples `step_s` apart.
    pub fn new(rows: usize, step_s: f64) -> Self {
        Self { rows, step_s, plan: fourier::Cosine::new(rows) }
    }

    /// c_k = √(2/n) Σ x_i cos(π k (i + ½)/n), k = 1 … n − 1: the mean is not in it.
    pub fn transform(&self, values: &[f64]) -> Vec<f64> {
        self.plan.transform(values, mean(values))
    }

    /// The coefficients of the weights of a mean over some rows, 1/m in each of these m: their product with c
    /// is that mean less the mean of all.
    ///
    /// w_k = √(2/n)/m · (sin(π k b/n) − sin(π k a/n))/(2 sin(π k/2n)) for the rows from a to before b.
    pub fn mean_over(&self, rows: Range<usize>) -> Vec<f64> {
        let scale = (2.0 / self.rows as f64).sqrt() / rows.len() as f64;
        let weight = |k: usize| {
            let step = PI * k as f64 / self.rows as f64;
            let ends = (step * rows.end as f64).sin() - (step * rows.start as f64).sin();
            scale * ends / (2.0 * (0.5 * step).sin())
        };
        (1..self.rows).map(weight).collect()
    }

    /// The frequency of c_k, k/(2nΔt) (Hz).
    pub fn frequency(&self, k: usize) -> f64 {
        k as f64 / (2.0 * self.rows as f64 * self.step_s)
    }
}
