//! Covariance of the lowest cosine coefficients of power-law noise.

use faer::Mat;
use statrs::function::gamma::gamma;
use std::f64::consts::{FRAC_PI_2, PI};

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
pub fn covariance(exponent: f64, count: usize) -> Mat<f64> {
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
