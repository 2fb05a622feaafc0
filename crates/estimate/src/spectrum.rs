//! Power spectral density of an evenly sampled series, by Welch's method.

use crate::Error;
use crate::cross_spectrum::{LEAST_SAMPLES, freedom, transform};

/// One-sided power spectral density: the integral from zero to the Nyquist frequency is the variance.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Frequencies f_k = k/(n Δt), k = 0 … n/2, n the samples of a segment (Hz).
    pub frequency_hz: Vec<f64>,
    /// Density at each frequency (square of the samples' unit, per Hz).
    pub density: Vec<f64>,
    /// Segments K averaged.
    pub segments: usize,
    /// Samples n of each segment.
    pub segment_samples: usize,
    /// Share of a segment that the next one has in common with it: ½, for odd n a little less.
    pub overlap: f64,
    /// Equivalent degrees of freedom ν of each estimate: ν P̂/P is about χ²(ν) where the density P changes
    /// little over 4/(n Δt). At zero and at the Nyquist frequency, where the transform is real, there are
    /// only half as many; next to zero the mean that was taken off is missing.
    pub freedom: f64,
}

/// Welch's estimate of the one-sided power spectral density of samples `step_s` seconds apart.
///
/// Segments of n = `segment_samples` start every D = n − ⌊n/2⌋ samples; what is left at the end is not used.
/// From each its mean is taken off, and the periodograms are averaged:
///
/// P(f_k) = c Δt / Σ w_m² · ⟨|Σ w_m (x_m − x̄) e^(−2πi k m/n)|²⟩, w_m = ½ − ½ cos(2π m/n),
///
/// with c = 2, and c = 1 at zero and at the Nyquist frequency (even n only). The window is the periodic Hann
/// window. More samples for a segment than there are in the series: one segment, the whole series. Samples
/// that are not finite give densities that are not finite.
///
/// The degrees of freedom are ν = 2K / (1 + 2 Σ (1 − j/K) ρ_j), j = 1 … K − 1, with
/// ρ_j = (Σ w_m w_(m+jD) / Σ w_m²)².
///
/// Source: P. D. Welch, The use of fast Fourier transform for the estimation of power spectra, IEEE Trans.
/// Audio Electroacoust. AU-15 (1967) 70–73.
///
/// Errors: [`Error::TooFew`] if the series, or a segment, has fewer than 8 samples.
pub fn welch(samples: &[f64], step_s: f64, segment_samples: usize) -> Result<Spectrum, Error> {
    let n = segment_samples.min(samples.len());
    if n < LEAST_SAMPLES {
        return Err(Error::TooFew { found: n, unknowns: LEAST_SAMPLES });
    }
    let common = n / 2;
    let hop = n - common;
    let window = hann(n);
    let mut density = vec![0.0; n / 2 + 1];
    let mut segments = 0;
    for segment in samples.windows(n).step_by(hop) {
        for (density, value) in density.iter_mut().zip(transform(segment, Some(&window))) {
            *density += value.norm_sqr();
        }
        segments += 1;
    }

    let scale = step_s / segments as f64;
    for (k, density) in density.iter_mut().enumerate() {
        let alone = k == 0 || 2 * k == n;
        *density *= if alone { scale } else { 2.0 * scale };
    }
    let length_s = n as f64 * step_s;
    Ok(Spectrum {
        frequency_hz: (0..density.len()).map(|k| k as f64 / length_s).collect(),
        density,
        segments,
        segment_samples: n,
        overlap: common as f64 / n as f64,
        freedom: freedom(&[window], hop, segments),
    })
}

impl Spectrum {
    /// The integral ∫ P df over the band `low_hz` … `high_hz` (square of the samples' unit).
    ///
    /// The density is a straight line between two frequencies, also at the ends of the band. The zero
    /// frequency is left out: what the band has below the first frequency after zero, or beyond the last one,
    /// adds nothing.
    pub fn power(&self, low_hz: f64, high_hz: f64) -> f64 {
        if low_hz.is_nan() || high_hz.is_nan() {
            return f64::NAN;
        }
        let points: Vec<(f64, f64)> =
            self.frequency_hz.iter().copied().zip(self.density.iter().copied()).skip(1).collect();
        points
            .windows(2)
            .map(|pair| {
                let ((left, p_left), (right, p_right)) = (pair[0], pair[1]);
                let (from, to) = (low_hz.max(left), high_hz.min(right));
                if from >= to {
                    return 0.0;
                }
                // The mean of a straight line over a stretch is its value in the middle.
                let middle = (0.5 * (from + to) - left) / (right - left);
                (p_left + (p_right - p_left) * middle) * (to - from)
            })
            .sum()
    }
}

/// The periodic Hann window ½ − ½ cos(2π m/n), m = 0 … n − 1, over the root of the sum of its squares, 3n/8.
fn hann(n: usize) -> Vec<f64> {
    let root = (0.375 * n as f64).sqrt();
    (0..n).map(|m| (std::f64::consts::PI * m as f64 / n as f64).sin().powi(2) / root).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_constant_has_no_density() {
        let spectrum = welch(&[50_000.1; 100], 0.1, 33).expect("a spectrum");
        assert!(spectrum.density.iter().all(|p| *p < 1e-20), "{:?}", spectrum.density);
    }
}
