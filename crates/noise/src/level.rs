//! Knowledge of the mean of readings, beside their noise.

use std::sync::Arc;

/// What it does to whitened readings L⁻¹y, where their mean is zero with the standard uncertainty s: they
/// become L⁻¹y + k u Σy/(n s), with u = Lᵀ1/(n s) and k = (√(1 + uᵀu) − 1)/uᵀu, so that the inverse of their
/// covariance is L⁻ᵀ(1 + u uᵀ)L⁻¹ = C⁻¹ + 1 1ᵀ/(n s)².
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// k u.
    direction: Arc<[f64]>,
    /// 1/(n s).
    weight: f64,
    /// uᵀu.
    square: f64,
}

impl Level {
    /// For u and 1/(n s).
    pub fn of(u: &[f64], weight: f64) -> Self {
        let square = u.iter().map(|u| u * u).sum::<f64>();
        let scale = ((1.0 + square).sqrt() - 1.0) / square;
        Self { direction: u.iter().map(|u| scale * u).collect(), weight, square }
    }

    /// The mean of readings over its standard uncertainty.
    pub fn known(&self, readings: &[f64]) -> f64 {
        self.weight * readings.iter().sum::<f64>()
    }

    /// Adds that to the readings when they are whitened.
    pub fn add(&self, known: f64, white: &mut [f64]) {
        white.iter_mut().zip(self.direction.iter()).for_each(|(white, u)| *white += u * known);
    }

    /// By how much it lowers ln det of the covariance: ln(1 + uᵀu).
    pub fn log_determinant(&self) -> f64 {
        self.square.ln_1p()
    }
}
