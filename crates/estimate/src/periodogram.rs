//! Periodogram of an evenly sampled series, its spectral lines taken out and the rest averaged into narrow bins.

use crate::Error;
use crate::stats::mean;

mod component;
mod level;
mod lines;

pub use lines::Line;

/// Fewer samples than these have no spectrum worth the name.
const LEAST_SAMPLES: usize = 8;
/// Widest bin, as a share of its lowest frequency.
const WIDEST_BIN: f64 = 0.02;
/// Shorter series are fast to transform whatever their length.
const SHORT: usize = 1 << 16;
/// The length of a series is a product of primes up to this one when its transform is to be fast.
const LARGEST_PRIME: usize = 13;
/// Share of the samples at the end that may be left out for a fast transform.
const LEFT_OUT: f64 = 0.01;

/// One-sided periodogram of a series, without its lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Periodogram {
    /// Length n Δt of the samples used (s).
    pub length_s: f64,
    /// Time Δt between two samples (s).
    pub step_s: f64,
    /// Samples n used.
    pub samples: usize,
    /// Averaged ordinates, frequencies rising.
    pub bins: Vec<Bin>,
    /// Spectral lines taken out, frequencies rising.
    pub lines: Vec<Line>,
}

/// Neighbouring ordinates, averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Mean of their Fourier frequencies (Hz).
    pub frequency_hz: f64,
    /// Mean of the ordinates (square of the samples' unit, per Hz).
    pub density: f64,
    /// How many ordinates.
    pub count: f64,
}

/// The periodogram of samples `step_s` seconds apart,
///
/// I(f_k) = 2 Δt/n |Σ (x_m − x̄) e^(−2πi k m/n)|², f_k = k/(n Δt), k = 1 … below n/2,
///
/// in the square of the samples' unit per Hz. There is no taper: for Gaussian noise whose density P changes little over
/// 1/(n Δt) the ordinates are independent, each P times an exponential variable of mean one. What is steeper than
/// about f^-2 leaks from the lowest frequencies into all others and then falls as f^-2.
///
/// Spectral lines are found at the full resolution, and a sine of each is subtracted; see [`Line`]. The ordinates next to a
/// line are left out. The others are averaged: single ordinates at low k, then bins no wider than 2 % of their
/// frequency. Of more than 65 536 samples up to 1 % at the end are not used where that makes a faster transform.
///
/// Source: M. B. Priestley, Spectral Analysis and Time Series, Academic Press 1981, section 6.1.
///
/// # Errors
///
/// [`Error::TooFew`] for fewer than 8 samples, [`Error::Series`] for samples that are not finite and for a step that is
/// not above zero.
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
    let plan = fourier::forward(n);
    let mut input: Vec<f64> = samples[..n].iter().map(|x| x - mean).collect();
    let mut transform = plan.make_output_vec();
    plan.process(&mut input, &mut transform).expect("buffers of the plan's lengths");
    drop(input);

    let length_s = n as f64 * step_s;
    // Ordinates k = 0 … below n/2; the one at zero is never used.
    transform.truncate(n.div_ceil(2));
    let (lines, rest) = lines::take_out(transform, n, length_s);
    let bins = bins(&rest.power, &rest.left_out, 2.0 * step_s / n as f64, length_s);
    Ok(Periodogram { length_s, step_s, samples: n, bins, lines })
}

/// Averages of what is not left out.
fn bins(power: &[f64], left_out: &[bool], scale: f64, length_s: f64) -> Vec<Bin> {
    let mut bins = Vec::new();
    let mut from = 1;
    while from < power.len() {
        let to = (from + ((WIDEST_BIN * from as f64) as usize).max(1)).min(power.len());
        let (mut count, mut order, mut sum) = (0_usize, 0_usize, 0.0);
        for k in (from..to).filter(|k| !left_out[*k]) {
            (count, order, sum) = (count + 1, order + k, sum + power[k]);
        }
        if count > 0 {
            let count = count as f64;
            let frequency_hz = order as f64 / count / length_s;
            bins.push(Bin { frequency_hz, density: scale * sum / count, count });
        }
        from = to;
    }
    bins
}

/// The largest even length with small prime factors only, if it leaves out no more than a hundredth; else the length.
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
        let power: Vec<f64> = (0..5000).map(f64::from).collect();
        let mut left_out = vec![false; 5000];
        left_out[700..710].fill(true);
        let bins = bins(&power, &left_out, 2.0, 10.0);
        assert_eq!(bins.iter().map(|bin| bin.count).sum::<f64>(), 4989.0);
        for bin in &bins {
            // The ordinates are k, so that their mean is the mean frequency.
            assert!((bin.density - 20.0 * bin.frequency_hz).abs() < 1e-9 * bin.density);
            let k = 10.0 * bin.frequency_hz;
            assert!(bin.count <= 1.0 || bin.count <= WIDEST_BIN * k, "{bin:?}");
        }
        assert!(bins.windows(2).all(|pair| pair[0].frequency_hz < pair[1].frequency_hz));
        assert!(bins[..99].iter().all(|bin| bin.count == 1.0));
    }
}
