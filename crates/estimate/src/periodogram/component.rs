//! A sine within the discrete Fourier transform of a series.

use std::f64::consts::PI;

use fourier::Complex;

use super::level::Level;
use crate::line_search::largest;

/// Ordinates on each side of a peak to which a sine is fitted.
const FITTED: usize = 8;
/// A peak lies no farther than this from its largest ordinate (ordinates).
const REACH: f64 = 0.6;
/// Frequencies tried over the reach of a peak before the best one is refined.
const TRIED: usize = 25;
/// Golden sections of that: to 1e-11 of an ordinate.
const SECTIONS: usize = 48;
/// What leaks from a sine is followed until it is this share of the local level.
const LEAKAGE: f64 = 1e-4;

/// x_m = c e^(2πi ν m/n) + c* e^(−2πi ν m/n).
#[derive(Clone, Copy, Debug)]
pub(super) struct Component {
    /// Cycles ν over the length of the series.
    pub order: f64,
    /// Half the complex amplitude, c.
    pub half: Complex<f64>,
}

/// D(d) = Σ e^(2πi d m/n), m = 0 … n − 1, d = ν − k: (1 − e^(2πi ν)) (1 + i cot(π d/n))/2.
struct Kernel {
    half_numerator: Complex<f64>,
    order: f64,
    n: f64,
}

impl Kernel {
    fn new(order: f64, n: usize) -> Self {
        let (sin, cos) = (PI * (order - order.round())).sin_cos();
        Kernel { half_numerator: Complex::new(sin, -cos) * sin, order, n: n as f64 }
    }

    fn at(&self, k: usize) -> Complex<f64> {
        let apart = self.order - k as f64;
        if self.half_numerator.norm_sqr() < 1e-26 {
            // A whole number of cycles is seen by its own ordinate only.
            return Complex::new(if apart.abs() < 0.5 { self.n } else { 0.0 }, 0.0);
        }
        self.half_numerator * Complex::new(1.0, 1.0 / (PI * apart / self.n).tan())
    }
}

impl Component {
    /// The sine of least squares at the peak with the largest ordinate `peak`, weighed by the local level.
    pub fn fit(transform: &[Complex<f64>], level: &Level, n: usize, peak: usize) -> Self {
        let window = peak.saturating_sub(FITTED).max(1)..(peak + FITTED + 1).min(transform.len());
        let weights: Vec<f64> = window.clone().map(|k| 1.0 / level.at(k)).collect();
        // The part of the weighted squares that a sine of this order explains, and its half amplitude.
        let explained = |order: f64| {
            let (kernel, image) = (Kernel::new(order, n), Kernel::new(-order, n));
            let (mut uu, mut uv, mut vv, mut ux, mut vx) = (0.0, 0.0, 0.0, 0.0, 0.0);
            for (k, weight) in window.clone().zip(&weights) {
                let (d, mirrored, x) = (kernel.at(k), image.at(k), transform[k]);
                let (u, v) = (d + mirrored, (d - mirrored) * Complex::i());
                uu += weight * u.norm_sqr();
                vv += weight * v.norm_sqr();
                uv += weight * (u.re * v.re + u.im * v.im);
                ux += weight * (u.re * x.re + u.im * x.im);
                vx += weight * (v.re * x.re + v.im * x.im);
            }
            let determinant = uu * vv - uv * uv;
            let half = Complex::new((ux * vv - vx * uv) / determinant, (vx * uu - ux * uv) / determinant);
            (half.re * ux + half.im * vx, half)
        };
        let step = 2.0 * REACH / (TRIED - 1) as f64;
        let tried = (0..TRIED).map(|i| peak as f64 - REACH + step * i as f64);
        let best = tried.max_by(|a, b| explained(*a).0.total_cmp(&explained(*b).0)).unwrap_or(peak as f64);
        let order = largest((best - step, best + step), SECTIONS, |order| explained(order).0);
        Component { order, half: explained(order).1 }
    }

    /// Its amplitude.
    pub fn amplitude(&self) -> f64 {
        2.0 * self.half.norm()
    }

    /// Subtracts the sine from the transform and brings the powers |X_k|² up to date.
    pub fn subtract(&self, transform: &mut [Complex<f64>], power: &mut [f64], level: &Level, n: usize) {
        let (kernel, image) = (Kernel::new(self.order, n), Kernel::new(-self.order, n));
        let peak = (self.order.round() as usize).clamp(1, transform.len() - 1);
        // Far from the peak the sine has the power |c n|²/(π d)² at a distance of d ordinates.
        let strength = (self.half.norm() * n as f64).powi(2) / level.at(peak);
        let reach = 2 * FITTED + ((strength / LEAKAGE).sqrt() / PI).min(n as f64) as usize;
        for k in peak.saturating_sub(reach).max(1)..(peak + reach + 1).min(transform.len()) {
            transform[k] -= self.half * kernel.at(k) + self.half.conj() * image.at(k);
            power[k] = transform[k].norm_sqr();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernel_by_its_sum() {
        for (order, n) in [(3.0, 10), (3.27, 10), (-3.27, 10), (7.5, 33), (2.000_001, 16)] {
            let kernel = Kernel::new(order, n);
            for k in 0..n.div_ceil(2) {
                let term =
                    |m: usize| Complex::from_polar(1.0, 2.0 * PI * (order - k as f64) * m as f64 / n as f64);
                let sum: Complex<f64> = (0..n).map(term).sum();
                assert!((kernel.at(k) - sum).norm() < 1e-8 * n as f64, "{order}, {k}: {sum}");
            }
        }
    }
}
