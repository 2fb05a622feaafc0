//! Covariance of η between the test instrument's axes, whose differences may have noise in common.

use estimate::cosine::dot;

/// Coefficients of the lowest band; each further band has as many as all below it.
const BAND: usize = 32;

/// The fit of one axis, whitened: coefficients of the cosine transform over their standard deviations.
pub struct Whitened {
    /// Weights of η of the reference's x, y, z: their sums of products are its covariance.
    pub weights: [Vec<f64>; 3],
    /// What is left.
    pub left: Vec<f64>,
}

/// Cov(η_ia, η_kb) = Σ_B ρ_B Σ_(k in B) w_ia w_kb over bands B, ρ_B how far what is left of the two axes goes together there.
///
/// Where an axis rests on a lower band than the other, its weights and what is left of it count as zero above; so the nine have a covariance
/// that is positive semidefinite.
pub fn covariance(a: &Whitened, b: &Whitened) -> [[f64; 3]; 3] {
    let mut sum = [[0.0; 3]; 3];
    let mut from = 0;
    while from < a.left.len().min(b.left.len()) {
        let to = from + from.max(BAND);
        let (left_a, left_b) = (band(&a.left, from, to), band(&b.left, from, to));
        let squares = dot(left_a, left_a) * dot(left_b, left_b);
        let together = if squares > 0.0 { dot(left_a, left_b) / squares.sqrt() } else { 0.0 };
        for (row, of_a) in sum.iter_mut().zip(&a.weights) {
            for (value, of_b) in row.iter_mut().zip(&b.weights) {
                *value += together * dot(band(of_a, from, to), band(of_b, from, to));
            }
        }
        from = to;
    }
    sum
}

fn band(values: &[f64], from: usize, to: usize) -> &[f64] {
    &values[from..to.min(values.len())]
}
