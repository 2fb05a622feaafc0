use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use crate::{Complex, forward};

/// Coefficients that one thread makes at once, and angles of which a sine and a cosine are computed.
const PIECE: usize = 1 << 12;

/// The cosine transform of N real numbers, of unit scale: sums of squares about the mean stay.
#[derive(Clone)]
pub struct Cosine {
    /// exp(−iπk/(2N)) for the first k.
    turns: Arc<Vec<Complex<f64>>>,
    points: usize,
}

impl Cosine {
    /// For `points` real numbers.
    pub fn new(points: usize) -> Self {
        Self { turns: Arc::new((0..points.min(PIECE)).map(|k| turn(k, points)).collect()), points }
    }

    /// c_k = √(2/N) Σ (x_i − m) cos(π k (i + ½)/N), k = 1 … N − 1; the constant m, which is in none of them,
    /// is to be near the mean.
    ///
    /// Source: J. Makhoul, A fast cosine transform in one and two dimensions, IEEE Trans. ASSP 28 (1980)
    /// 27–34.
    pub fn transform(&self, values: &[f64], middle: f64) -> Vec<f64> {
        let points = self.points;
        let mut folded = vec![0.0; points];
        let (front, back) = folded.split_at_mut(points.div_ceil(2));
        front.iter_mut().zip(values.chunks(2)).for_each(|(to, pair)| *to = pair[0] - middle);
        back.iter_mut().rev().zip(values.chunks_exact(2)).for_each(|(to, pair)| *to = pair[1] - middle);
        let output = forward(folded);
        let scale = (2.0 / points as f64).sqrt();
        let mut coefficients = vec![0.0; points.saturating_sub(1)];
        coefficients.par_chunks_mut(PIECE).enumerate().for_each(|(piece, coefficients)| {
            let first = 1 + piece * PIECE;
            let (to_first, turns) = (scale * turn(first, points), self.turns.iter());
            for (k, (to, turn)) in (first..).zip(coefficients.iter_mut().zip(turns)) {
                let at = if k < output.len() { output[k] } else { output[points - k].conj() };
                *to = (at * (to_first * turn)).re;
            }
        });
        coefficients
    }
}

fn turn(k: usize, points: usize) -> Complex<f64> {
    Complex::from_polar(1.0, -FRAC_PI_2 * k as f64 / points as f64)
}
