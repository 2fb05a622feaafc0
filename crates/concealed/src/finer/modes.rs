//! Bodies into which heat or a field diffuses, and matter without one time constant, as sums of lags (see
//! [`super::beside`]): weights and time constants over the longest, or over the middle one.

use std::f64::consts::{PI, TAU};

/// Zeros of the Bessel function J₀.
const ZEROS: [f64; 6] = [
    2.404_825_557_695_773,
    5.520_078_110_286_311,
    8.653_727_912_911_013,
    11.791_534_439_014_281,
    14.930_917_708_487_786,
    18.071_063_967_910_924,
];

fn to_one<const N: usize>(modes: [(f64, f64); N]) -> [(f64, f64); N] {
    let sum: f64 = modes.iter().map(|(weight, _)| weight).sum();
    modes.map(|(weight, tau)| (weight / sum, tau))
}

/// Mean over the section of a long round rod whose surface follows a signal: w_n = 4 / j_n², τ_n = τ (j_1 /
/// j_n)², j_n the zeros of J₀; six of them, scaled to a sum of 1. Source: Carslaw and Jaeger 1959, Conduction
/// of Heat in Solids, section 7.6.
pub fn rod() -> [(f64, f64); 6] {
    to_one(ZEROS.map(|j| (4.0 / (j * j), (ZEROS[0] / j).powi(2))))
}

/// Mean over a sphere whose surface follows a signal: w_n = 6 / (π n)², τ_n = τ / n²; six of them, scaled to
/// a sum of 1. Source: Carslaw and Jaeger 1959, Conduction of Heat in Solids, section 9.3.
pub fn sphere() -> [(f64, f64); 6] {
    to_one(std::array::from_fn(|k| {
        let n = (k + 1) as f64;
        (6.0 / (PI * n).powi(2), 1.0 / (n * n))
    }))
}

/// A symmetric spread of time constants about a middle one, as disordered matter and a conducting half space
/// have it: the transfer function 1 / (1 + (iωτ)^a), 0 < a < 1, whose relaxation times have the density
///
/// ```text
/// g(x) = sin(a π) / (cosh(a x) + cos(a π)) / 2π,   x = ln(τ_n / τ)
/// ```
///
/// in N points of x between ± `reach`, scaled to a sum of 1. Source: Cole and Cole 1941, Dispersion and
/// absorption in dielectrics, J. Chem. Phys. 9, 341.
pub fn spread<const N: usize>(exponent: f64, reach: f64) -> [(f64, f64); N] {
    to_one(std::array::from_fn(|k| {
        let x = reach * (2.0 * k as f64 / (N - 1) as f64 - 1.0);
        let density = (exponent * PI).sin() / ((exponent * x).cosh() + (exponent * PI).cos()) / TAU;
        (density, x.exp())
    }))
}

/// Mean lag of a sum of lags, in its unit of time.
pub fn mean_lag<const N: usize>(modes: &[(f64, f64); N]) -> f64 {
    modes.iter().map(|(weight, tau)| weight * tau).sum()
}

/// The modes with their times in seconds.
pub fn seconds<const N: usize>(modes: [(f64, f64); N], tau_s: f64) -> [(f64, f64); N] {
    modes.map(|(weight, tau)| (weight, tau * tau_s))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;

    /// J₀(x) = ∫ cos(x sin θ) dθ / π vanishes at each of the zeros.
    #[test]
    fn the_zeros_are_zeros() {
        for j in ZEROS {
            let sum: f64 = (0..200).map(|k| (j * (PI * f64::from(k) / 200.0).sin()).cos()).sum();
            assert!((sum / 200.0).abs() < 1e-12, "{j}");
        }
    }

    /// A slow course is late by a² / 8D in a rod and by a² / 15D in a sphere of radius a, but for the modes
    /// that are left out.
    #[test]
    fn slow_courses_are_late_by_the_known_times() {
        assert!((mean_lag(&rod()) / (ZEROS[0].powi(2) / 8.0) - 1.0).abs() < 0.1);
        assert!((mean_lag(&sphere()) / (PI * PI / 15.0) - 1.0).abs() < 0.15);
        let sum = |modes: &[(f64, f64)]| modes.iter().map(|(weight, _)| weight).sum::<f64>();
        assert!((sum(&rod()) - 1.0).abs() < 1e-12 && (sum(&sphere()) - 1.0).abs() < 1e-12);
    }

    /// The sum of lags has Cole and Cole's transfer function.
    #[test]
    fn a_spread_has_its_transfer_function() {
        for exponent in [0.5, 0.8] {
            let lags = spread::<81>(exponent, 16.0);
            for omega in [0.05, 0.5, 1.0, 4.0, 30.0] {
                let found: Complex<f64> =
                    lags.iter().map(|(w, tau)| w / Complex::new(1.0, omega * tau)).sum();
                let exact = 1.0 / (1.0 + Complex::new(0.0, omega).powf(exponent));
                assert!((found - exact).norm() < 0.01, "{exponent} {omega}: {found} for {exact}");
            }
        }
    }
}
