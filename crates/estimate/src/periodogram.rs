//! Spectrum of an even series without its lines: squares of its cosine transform in narrow bins.

use std::ops::Range;

use fourier::Complex;
use rayon::prelude::*;

use crate::Error;
use crate::cross_spectrum::{LEAST_SAMPLES, WIDEST_BIN, bins};
use crate::stats::mean;

mod component;
mod level;
mod lines;

pub use lines::Line;

/// Shorter series are fast to transform whatever their length.
const SHORT: usize = 1 << 16;
/// The length of a series is a product of primes up to this one when its transform is to be fast.
const LARGEST_PRIME: usize = 13;
/// Share of the samples at the end that may be left out for a fast transform.
const LEFT_OUT: f64 = 0.01;

/// One-sided spectrum of a series, without its lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Periodogram {
    /// Length n Δt of the samples used (s).
    pub length_s: f64,
    /// Time Δt between two samples (s).
    pub step_s: f64,
    /// Samples n used.
    pub samples: usize,
    /// Whether the ordinates are those of a cosine transform as it came: of noise f^-α that goes on at both
    /// ends number k is lower, in the mean, by the share 2 α (2 − α)/(π² k).
    pub mirrored: bool,
    /// Averaged ordinates, frequencies rising.
    pub bins: Vec<Bin>,
    /// Spectral lines taken out, frequencies rising.
    pub lines: Vec<Line>,
}

/// Neighbouring ordinates, averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Mean of their frequencies (Hz).
    pub frequency_hz: f64,
    /// Mean of the ordinates (square of the samples' unit, per Hz).
    pub density: f64,
    /// How many ordinates of a Fourier transform they are worth: half of their number.
    pub count: f64,
}

/// The ordinates of samples `step_s` seconds apart,
///
/// I(f_k) = 2 Δt c_k², c_k = √(2/n) Σ x_m cos(π k (m + ½)/n), f_k = k/(2n Δt), k = 1 … n − 1,
///
/// in the square of the samples' unit per Hz; each counts as half an ordinate of a Fourier transform. The
/// cosine transform goes on with the series as its mirror image: noise that was there before and goes on
/// afterwards does not jump at the ends, and its lowest frequencies do not leak into all others. For Gaussian
/// noise whose density P falls no faster than f^-2 the ordinates are independent, each P times a squared
/// normal variable, nearly (see [`Periodogram::mirrored`]): of white noise and of a random walk exactly.
/// There is no taper.
///
/// Spectral lines are found in the Fourier transform, and a sine of each is subtracted; see [`Line`]. The
/// ordinates next to a line are left out. The others are averaged: single ordinates at low k, then bins no
/// wider than 2 % of their frequency. Of more than 65 536 samples up to 1 % at the end are not used where
/// that makes a faster transform.
///
/// Sources: M. B. Priestley, Spectral Analysis and Time Series, Academic Press 1981, section 6.1; N. Ahmed,
/// T. Natarajan and K. R. Rao, Discrete cosine transform, IEEE Trans. Comput. C-23 (1974) 90–93.
///
/// Errors: [`Error::TooFew`] for fewer than 8 samples, [`Error::Series`] for samples that are not finite
/// and for a step that is not above zero.
pub fn periodogram(samples: &[f64], step_s: f64) -> Result<Periodogram, Error> {
    if samples.len() < LEAST_SAMPLES {
        return Err(Error::TooFew { found: samples.len(), unknowns: LEAST_SAMPLES });
    }
    if !(step_s > 0.0 && step_s.is_finite()) {
        return Err(Error::Series("whose step is not above zero"));
    }
    let n = fast_length(samples.len());
    let mean = mean(&samples[..n]);
    if !mean.is_finite() {
        return Err(Error::Series("with samples that are not finite"));
    }
    let mut transform = fourier::forward(samples[..n].iter().map(|x| x - mean).collect());
    let length_s = n as f64 * step_s;
    // Lines are sought at k = 0 … below n/2.
    let nyquist = transform.split_off(n.div_ceil(2));
    let (lines, left_out) = lines::take_out(&mut transform, n, length_s);
    let coefficients = if lines.is_empty() {
        drop((transform, nyquist));
        fourier::Cosine::new(n).transform(&samples[..n], mean)
    } else {
        transform.extend(nyquist);
        transform[0] = Complex::default();
        let mut series = fourier::inverse(transform, n);
        series.iter_mut().for_each(|x| *x /= n as f64);
        fourier::Cosine::new(n).transform(&series, 0.0)
    };
    let bins = averages(&coefficients, &left_out, step_s);
    Ok(Periodogram { length_s, step_s, samples: n, mirrored: true, bins, lines })
}

/// Averages of the ordinates of c_1, c_2, …, without those between Fourier frequencies that are left out.
fn averages(coefficients: &[f64], left_out: &[bool], step_s: f64) -> Vec<Bin> {
    let length_s = (coefficients.len() + 1) as f64 * step_s;
    let out = |order: usize| order > 0 && left_out.get(order).is_some_and(|out| *out);
    let average = |places: Range<usize>| {
        let (mut number, mut order, mut sum) = (0_usize, 0_usize, 0.0);
        for k in places.map(|place| place + 1).filter(|k| !out(k / 2) && !out(k.div_ceil(2))) {
            (number, order, sum) = (number + 1, order + k, sum + coefficients[k - 1].powi(2));
        }
        let count = number as f64;
        (number > 0).then(|| Bin {
            frequency_hz: order as f64 / count / (2.0 * length_s),
            density: 2.0 * step_s * sum / count,
            count: 0.5 * count,
        })
    };
    let places: Vec<Range<usize>> = bins(coefficients.len(), WIDEST_BIN).collect();
    places.into_par_iter().filter_map(average).collect()
}

/// The largest even length with small prime factors that leaves out at most a hundredth; else the length.
fn fast_length(n: usize) -> usize {
    if n <= SHORT {
        return n;
    }
    let least = n - (LEFT_OUT * n as f64) as usize;
    (least..=n).rev().find(|length| length % 2 == 0 && has_small_factors(*length)).unwrap_or(n)
}

fn has_small_factors(mut n: usize) -> bool {
    for prime in 2..=LARGEST_PRIME {
        while n.is_multiple_of(prime) {
            n /= prime;
        }
    }
    n == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fast_lengths() {
        assert_eq!(fast_length(601), 601, "short series are used whole");
        assert_eq!(fast_length(8_640_000), 8_640_000);
        for n in [65_537, 100_003, 999_983, 8_639_999, 8_640_001] {
            let fast = fast_length(n);
            assert!(fast <= n && fast as f64 >= 0.99 * n as f64 && has_small_factors(fast), "{n}: {fast}");
        }
    }

    #[test]
    fn bins_are_narrow_and_hold_every_ordinate_once() {
        let coefficients: Vec<f64> = (1..10_000).map(|k| f64::from(k).sqrt()).collect();
        let mut left_out = vec![false; 5000];
        left_out[700..710].fill(true);
        let bins = averages(&coefficients, &left_out, 0.001);
        // Left out are 1399 to 1419.
        assert_eq!(bins.iter().map(|bin| bin.count).sum::<f64>(), 0.5 * (9999.0 - 21.0));
        for bin in &bins {
            // The squares are k, so that their mean is the mean frequency.
            let k = 20.0 * bin.frequency_hz;
            assert!((bin.density - 0.002 * k).abs() < 1e-9 * bin.density);
            assert!(2.0 * bin.count <= 1.0 || 2.0 * bin.count <= WIDEST_BIN * k, "{bin:?}");
        }
        assert!(bins.windows(2).all(|pair| pair[0].frequency_hz < pair[1].frequency_hz));
        assert!(bins[..99].iter().all(|bin| bin.count == 0.5));
    }
}
