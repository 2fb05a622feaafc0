//! Covariance of least-squares coefficients that holds under autocorrelation.

use faer::{Mat, MatRef};

/// Lags after Newey and West 1994 for the Bartlett kernel: ⌊4 (n/100)^(2/9)⌋.
pub fn lags(rows: usize) -> usize {
    (4.0 * (rows as f64 / 100.0).powf(2.0 / 9.0)).floor() as usize
}

/// The covariance of β of y ≈ X β by Newey and West (1987, Econometrica 55, 703):
///
/// n/(n − p) (XᵀX)⁻¹ [Γ₀ + Σ (1 − l/(L + 1)) (Γ_l + Γ_lᵀ)] (XᵀX)⁻¹, Γ_l = Σ_t e_t e_(t−l) x_t x_(t−l)ᵀ,
///
/// l = 1 … L, e the residuals in the order of time, at even steps; `inverse` is (XᵀX)⁻¹.
pub fn newey_west(
    design: MatRef<'_, f64>,
    residuals: &[f64],
    inverse: MatRef<'_, f64>,
    lags: usize,
) -> Mat<f64> {
    let (rows, unknowns) = (design.nrows(), design.ncols());
    let scores = Mat::from_fn(rows, unknowns, |i, j| design[(i, j)] * residuals[i]);
    let mut middle = Mat::<f64>::zeros(unknowns, unknowns);
    for lag in 0..=lags.min(rows.saturating_sub(1)) {
        let weight = 1.0 - lag as f64 / (lags as f64 + 1.0);
        let later = scores.as_ref().subrows(lag, rows - lag);
        let earlier = scores.as_ref().subrows(0, rows - lag);
        let product = later.transpose() * earlier;
        for i in 0..unknowns {
            for j in 0..unknowns {
                let both = if lag == 0 { product[(i, j)] } else { product[(i, j)] + product[(j, i)] };
                middle[(i, j)] += weight * both;
            }
        }
    }
    let factor = rows as f64 / (rows - unknowns) as f64;
    let all = inverse * middle * inverse;
    Mat::from_fn(unknowns, unknowns, |i, j| factor * all[(i, j)])
}
