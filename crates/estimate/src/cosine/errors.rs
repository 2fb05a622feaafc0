//! Covariance of the cosine coefficients of errors.

use faer::Mat;
use statrs::function::gamma::gamma;
use std::f64::consts::{FRAC_PI_2, PI};

use super::transform::Cosine;
use crate::Error;
use crate::linear::dot;
use crate::positive::cholesky;
use crate::whittle::WhittleFit;

/// Coefficients whose covariance is exact; the others are independent.
const EXACT: usize = 64;

/// Covariance of the cosine coefficients of errors.
pub struct Errors {
    low: Mat<f64>,
    factor: Mat<f64>,
    /// P(f_k)/(2Δt) of those in `low`, where the variance is another.
    pub(super) nominal: Vec<f64>,
    pub(super) variance: Vec<f64>,
}

impl Errors {
    /// Independent errors of variance one.
    pub fn independent(cosine: &Cosine) -> Self {
        let none = Mat::zeros(0, 0);
        Self { factor: none.clone(), low: none, nominal: Vec::new(), variance: vec![1.0; cosine.rows - 1] }
    }

    /// Errors of the noise that was fitted to one series: flicker and white.
    ///
    /// Variance of c_k: P(f_k)/(2Δt). The flicker part of the first 64 has the covariance of noise that did
    /// not begin with the series, down to the frequency zero: for α = 1 the variance of c_1 is 0.77 of that,
    /// and c_1 and c_3 correlate by −0.12. The variance of a straight line's slope is then right to 2 %, of
    /// an exponential's size to 10 % for a time constant of a fiftieth of the series; for a three-hundredth
    /// it is up to 40 % too great.
    ///
    /// Errors: [`Error::Decomposition`] if the covariance is none.
    pub fn of(noise: &WhittleFit, cosine: &Cosine) -> Result<Self, Error> {
        let (amplitude, exponent) = (noise.amplitude.value, noise.exponent.value);
        let white = noise.white_variances[0];
        let flicker = |k: usize| match amplitude {
            0.0 => 0.0,
            _ => amplitude * (-exponent * cosine.frequency(k).ln()).exp() / (2.0 * cosine.step_s),
        };
        let mut variance: Vec<f64> = (1..cosine.rows).map(|k| flicker(k) + white).collect();
        let exact = if amplitude > 0.0 { EXACT.min(variance.len() / 4) } else { 0 };
        let shape = covariance(exponent, exact);
        let root: Vec<f64> = (1..=exact).map(|k| flicker(k).sqrt()).collect();
        let low = Mat::from_fn(exact, exact, |i, j| {
            root[i] * root[j] * shape[(i, j)] + if i == j { white } else { 0.0 }
        });
        let nominal = variance[..exact].to_vec();
        (0..exact).for_each(|k| variance[k] = low[(k, k)]);
        Ok(Self { factor: cholesky(low.as_ref())?.L().to_owned(), low, nominal, variance })
    }

    /// The same with the variances times `factor` at each frequency (Hz), correlations as they were.
    pub fn scaled(mut self, cosine: &Cosine, factor: impl Fn(f64) -> f64) -> Self {
        for (row, variance) in self.variance.iter_mut().enumerate() {
            let factor = factor(cosine.frequency(row + 1));
            *variance *= factor;
            if let Some(nominal) = self.nominal.get_mut(row) {
                *nominal *= factor;
                let root = factor.sqrt();
                for column in 0..self.low.ncols() {
                    self.factor[(row, column)] *= root;
                    self.low[(row, column)] *= root;
                    self.low[(column, row)] *= root;
                }
            }
        }
        self
    }

    /// L⁻¹ x, L Lᵀ the covariance.
    pub fn whiten(&self, x: &[f64]) -> Vec<f64> {
        let exact = self.factor.nrows();
        let mut whitened: Vec<f64> =
            x.iter().zip(&self.variance).map(|(x, variance)| x / variance.sqrt()).collect();
        for i in 0..exact {
            let known: f64 = (0..i).map(|j| self.factor[(i, j)] * whitened[j]).sum();
            whitened[i] = (x[i] - known) / self.factor[(i, i)];
        }
        whitened
    }

    /// The covariance xᵀ C y of two linear estimates with these weights.
    pub fn covariance_of(&self, x: &[f64], y: &[f64]) -> f64 {
        dot(x, &self.times(y))
    }

    /// The covariance times x.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut product: Vec<f64> = x.iter().zip(&self.variance).map(|(x, variance)| x * variance).collect();
        let exact = self.low.nrows();
        for (i, value) in product.iter_mut().enumerate().take(exact) {
            *value = (0..exact).map(|j| self.low[(i, j)] * x[j]).sum();
        }
        product
    }
}

/// Averages into which the series is cut.
const BLOCKS: usize = 256;

/// Cov(c_k, c_l)/√(S_k S_l), k, l = 1 … `count` (64 at most), of noise with the one-sided density f^-α down
/// to the frequency zero; S_k = f_k^-α/(2Δt), f_k = k/(2nΔt). The same for all n and Δt; right to 2e-4 up to
/// k = 10, to 0.016 at 64 (α ≥ 0.5).
///
/// Averages over neighbouring stretches of unit length have, up to a constant that no c_k sees,
///
/// Cov(j) = (2π)^(α−1)/Γ(α) · (z/sin z) · [g(j + 1) − 2 g(j) + g(j − 1)],
/// g(u) = (|u|^(α+1) − u²)/((1 − α) α (α + 1)), z = (1 − α) π/2,
///
/// the second difference of the generalised covariance ∫ f^-α cos(2πfu) df, integrated twice; 0 < α < 3.
///
/// Source: B. B. Mandelbrot and J. W. Van Ness, Fractional Brownian motions, fractional noises and
/// applications, SIAM Rev. 10 (1968) 422–437; their law continued to α ≥ 1.
fn covariance(exponent: f64, count: usize) -> Mat<f64> {
    let beyond = exponent - 1.0;
    let z = -beyond * FRAC_PI_2;
    let ratio = if z == 0.0 { 1.0 } else { z / z.sin() };
    let scale = (2.0 * PI).powf(beyond) / gamma(exponent) * ratio / (exponent * (exponent + 1.0));
    let g = |lag: usize| {
        let u = lag as f64;
        match lag {
            0 => 0.0,
            _ if beyond == 0.0 => -u * u * u.ln(),
            _ => -u * u * (beyond * u.ln()).exp_m1() / beyond,
        }
    };
    let lags: Vec<f64> = (0..BLOCKS).map(|j| scale * (g(j + 1) - 2.0 * g(j) + g(j.abs_diff(1)))).collect();
    let blocks = BLOCKS as f64;
    let angle = |k: usize| (k + 1) as f64 * PI / (2.0 * blocks);
    // An average has lost sin x/x of a cosine, x half the angle it turns through.
    let basis = Mat::from_fn(BLOCKS, count, |i, k| {
        let x = angle(k);
        (2.0 / blocks).sqrt() * ((2 * i + 1) as f64 * x).cos() * x
            / x.sin()
            / (0.5 * ((k + 1) as f64 / (2.0 * blocks)).powf(-exponent)).sqrt()
    });
    let all = Mat::from_fn(BLOCKS, BLOCKS, |i, j| lags[i.abs_diff(j)]);
    basis.transpose() * (&all * &basis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use testkit::reference::{list, number, reference};

    #[test]
    fn as_integrated_over_frequency() {
        let mut worst = [0.0_f64; 2];
        for case in list(&reference("cosine_memory")["cases"]) {
            let found = covariance(number(&case["exponent"]), 64);
            for entry in list(&case["covariance"]) {
                let [k, l] = [0, 1].map(|i| number(&entry[i]) as usize);
                let difference = (found[(k - 1, l - 1)] - number(&entry[2])).abs();
                let high = &mut worst[usize::from(k > 10)];
                *high = high.max(difference);
            }
        }
        // Averages over a 256th of the series: what is faster is folded into the last coefficients.
        assert!(worst[0] < 2e-4 && worst[1] < 0.02, "{worst:?}");
    }
}
