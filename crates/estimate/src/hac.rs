//! Covariance of least-squares coefficients that holds under autocorrelation.

use faer::{Mat, MatRef};

use crate::linear::dot;

/// Lags after Newey and West 1994 for the Bartlett kernel: ⌊4 (n/100)^(2/9)⌋.
pub fn lags(rows: usize) -> usize {
    (4.0 * (rows as f64 / 100.0).powf(2.0 / 9.0)).floor() as usize
}

/// Rows whose scores are made at once.
const BLOCK: usize = 4096;

/// The covariance of β of y ≈ X β by Newey and West (1987, Econometrica 55, 703):
///
/// n/(n − p) (XᵀX)⁻¹ [Γ₀ + Σ (1 − l/(L + 1)) (Γ_l + Γ_lᵀ)] (XᵀX)⁻¹, Γ_l = Σ_t e_t e_(t−l) x_t x_(t−l)ᵀ,
///
/// l = 1 … L, e the residuals in the order of time, at even steps; `design` has the columns of X, `inverse`
/// is (XᵀX)⁻¹.
pub fn newey_west(design: &[&[f64]], residuals: &[f64], inverse: MatRef<'_, f64>, lags: usize) -> Mat<f64> {
    let (rows, unknowns) = (residuals.len(), design.len());
    let mut middle = Mat::<f64>::zeros(unknowns, unknowns);
    for first in (0..rows).step_by(BLOCK) {
        let (from, to) = (first.saturating_sub(lags), (first + BLOCK).min(rows));
        let score = |column: &&[f64]| -> Vec<f64> {
            column[from..to].iter().zip(&residuals[from..to]).map(|(x, e)| x * e).collect()
        };
        let scores: Vec<Vec<f64>> = design.iter().map(score).collect();
        for lag in 0..=lags.min(to - 1) {
            let weight = 1.0 - lag as f64 / (lags as f64 + 1.0);
            // Rows of this block that have one so many rows before them.
            let later = first.max(lag) - from;
            for i in 0..unknowns {
                for j in 0..unknowns {
                    let product = weight * dot(&scores[i][later..], &scores[j][later - lag..]);
                    middle[(i, j)] += product;
                    if lag > 0 {
                        middle[(j, i)] += product;
                    }
                }
            }
        }
    }
    let factor = rows as f64 / (rows - unknowns) as f64;
    let all = inverse * middle * inverse;
    Mat::from_fn(unknowns, unknowns, |i, j| factor * all[(i, j)])
}
