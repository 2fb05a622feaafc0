use fourier::Complex;

use crate::Stream;

/// Noise with the one-sided spectrum P(f) = A f^-α (nT²/Hz) on an even grid of n points.
///
/// Timmer and König 1995: each Fourier frequency f_k = k/(nΔt), k ≥ 1, gets a complex normal amplitude with
/// the power P(f_k)/(nΔt), so that the expected periodogram is P at every f_k, from one over the length of
/// the series to the Nyquist frequency; there is nothing below. One inverse FFT, n log n.
pub fn power_law(stream: &mut Stream, points: usize, step_s: f64, amplitude: f64, exponent: f64) -> Vec<f64> {
    if points < 2 {
        return vec![0.0; points];
    }
    let drawn = |(k, power): (usize, f64)| {
        let size = (power / 2.0).sqrt();
        match k {
            0 => Complex::default(),
            // The Nyquist frequency is real and stands for half a cell.
            k if 2 * k == points => Complex::new(stream.normal() * size * std::f64::consts::SQRT_2, 0.0),
            _ => Complex::new(stream.normal() * size, stream.normal() * size),
        }
    };
    let powers = powers(points, step_s, amplitude, exponent);
    fourier::inverse(powers.into_iter().enumerate().map(drawn).collect(), points)
}

/// The variance at each Fourier frequency of an even grid, on one side of the spectrum: a transform counts
/// each frequency twice but the Nyquist frequency once, which stands for half a cell. None at zero.
pub(crate) fn powers(points: usize, step_s: f64, amplitude: f64, exponent: f64) -> Vec<f64> {
    let resolution = 1.0 / (points as f64 * step_s);
    let power = |k: usize| match k {
        0 => 0.0,
        k => amplitude * (k as f64 * resolution).powf(-exponent) * resolution / 2.0,
    };
    (0..points / 2 + 1).map(power).collect()
}

/// A random walk: zero at the first row, a normal step of `per_sqrt_s` √Δt from row to row (nT).
pub fn random_walk(stream: &mut Stream, time_s: &[f64], per_sqrt_s: f64) -> Vec<f64> {
    let mut sum = 0.0;
    let steps = time_s.windows(2).map(|pair| {
        sum += stream.normal() * per_sqrt_s * (pair[1] - pair[0]).max(0.0).sqrt();
        sum
    });
    std::iter::once(0.0).take(time_s.len()).chain(steps).collect()
}
