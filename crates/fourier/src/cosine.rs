use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use crate::{Complex, forward};

/// Coefficients that one thread makes at once.
const PIECE: usize = 1 << 14;

/// The cosine transform of N real numbers, of unit scale: sums of squares about the mean stay.
#[derive(Clone)]
pub struct Cosine {
    turns: Arc<Vec<Complex<f64>>>,
}

impl Cosine {
    /// For `points` real numbers.
    pub fn new(points: usize) -> Self {
        Self { turns: Arc::new((0..points).map(|k| turn(k, points)).collect()) }
    }

    /// As [`cosine`].
    pub fn transform(&self, values: &[f64], middle: f64) -> Vec<f64> {
        transform(values, middle, |k| self.turns[k])
    }
}

/// c_k = √(2/N) Σ (x_i − m) cos(π k (i + ½)/N), k = 1 … N − 1; the constant m, which is in none of them, is
/// to be near the mean.
///
/// Source: J. Makhoul, A fast cosine transform in one and two dimensions, IEEE Trans. ASSP 28 (1980) 27–34.
pub fn cosine(values: &[f64], middle: f64) -> Vec<f64> {
    let points = values.len();
    transform(values, middle, |k| turn(k, points))
}

fn turn(k: usize, points: usize) -> Complex<f64> {
    Complex::from_polar(1.0, -FRAC_PI_2 * k as f64 / points as f64)
}

fn transform(values: &[f64], middle: f64, turn: impl Fn(usize) -> Complex<f64> + Sync) -> Vec<f64> {
    let points = values.len();
    let even = values.iter().step_by(2);
    let odd = values.iter().skip(1).step_by(2).rev();
    let output = forward(even.chain(odd).map(|value| value - middle).collect());
    let scale = (2.0 / points as f64).sqrt();
    (1..points)
        .into_par_iter()
        .with_min_len(PIECE)
        .map(|k| {
            let at = if k < output.len() { output[k] } else { output[points - k].conj() };
            scale * (at * turn(k)).re
        })
        .collect()
}
