//! Overlapping Allan deviation of an evenly sampled series.

use rayon::prelude::*;

use crate::whittle::WhittleFit;
use crate::{Error, stats};

/// The longest averaging time is the last one of which the samples hold this many averages without overlap.
///
/// Of random-walk noise such an estimate has two degrees of freedom, of white noise four.
const LEAST_AVERAGES: usize = 4;

/// The Allan deviation at one averaging time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AllanPoint {
    /// Averaging time τ = m Δt (s).
    pub averaging_s: f64,
    /// Estimate σ̂ of the Allan deviation σ(τ) (the samples' unit).
    pub deviation: f64,
    /// Equivalent degrees of freedom ν: ν σ̂²/σ² is about χ²(ν).
    pub freedom: f64,
}

/// Overlapping Allan deviations of the averages of samples `step_s` seconds apart, at m = 1, 2, 4, … samples
/// as long as 4m ≤ n.
///
/// σ̂² = Σ (x_(i+2m) − 2x_(i+m) + x_i)² / (2m²(N − 2m)), i = 0 … N − 2m − 1,
///
/// with the N = n + 1 sums x_i of the first i samples, each less the mean of all. Drift is not taken off: samples that
/// rise by d per second add d²τ²/2 to σ̂². Samples that are not finite give deviations that are not.
///
/// Source: W. J. Riley, Handbook of Frequency Stability Analysis, NIST Special Publication 1065 (2008), Table
/// 5; the samples stand for fractional frequency, their sums for phase.
///
/// Errors: [`Error::TooFew`] for fewer than 4 samples.
pub struct Deviations {
    step_s: f64,
    /// Sums x_i.
    sums: usize,
    /// m, and the deviation of averages of so many samples.
    of_lengths: Vec<(usize, f64)>,
}

impl Deviations {
    /// Of a series.
    pub fn of(samples: &[f64], step_s: f64) -> Result<Self, Error> {
        let longest = samples.len() / LEAST_AVERAGES;
        if longest == 0 {
            return Err(Error::TooFew { found: samples.len(), unknowns: LEAST_AVERAGES });
        }
        let sums = sums(samples);
        let lengths: Vec<usize> = (0..=longest.ilog2()).map(|octave| 1 << octave).collect();
        let of_lengths = lengths.into_par_iter().map(|m| (m, variance(&sums, m).sqrt())).collect();
        Ok(Self { step_s, sums: sums.len(), of_lengths })
    }

    /// With the degrees of freedom: `exponent` gives for an averaging time τ (s) the α of the power law
    /// P(f) ~ f^(−α) of the samples' density that dominates there; it is rounded to 0 (white), 1 (flicker) or 2
    /// (random walk). Degrees of freedom are those of Riley, Table 5, at most the pairs that are averaged; NaN
    /// for an exponent that is NaN.
    pub fn points(&self, exponent: impl Fn(f64) -> f64) -> Vec<AllanPoint> {
        let point = |&(m, deviation): &(usize, f64)| {
            let averaging_s = m as f64 * self.step_s;
            AllanPoint { averaging_s, deviation, freedom: freedom(self.sums, m, exponent(averaging_s)) }
        };
        self.of_lengths.iter().map(point).collect()
    }

    /// The same of samples whose noise was fitted: the flicker's α where its density at the frequency 1/(2τ)
    /// is above the white one, the greatest of those that were fitted, else white.
    pub fn of_noise(&self, noise: &WhittleFit) -> Vec<AllanPoint> {
        let rms = noise.white_rms.iter().map(|white| white.value).fold(0.0, f64::max);
        let white = 2.0 * rms.powi(2) * self.step_s;
        self.points(|averaging_s| {
            let flicker = noise.flicker_density(0.5 / averaging_s).value;
            if flicker > white { noise.exponent.value } else { 0.0 }
        })
    }
}

impl AllanPoint {
    /// The band that holds the true deviation with `probability`, half of the rest on either side (the
    /// samples' unit); see [`stats::variance_interval`].
    pub fn band(&self, probability: f64) -> [f64; 2] {
        let (low, high) = stats::variance_interval(self.freedom, probability);
        [low, high].map(|factor| self.deviation * factor.sqrt())
    }
}

/// The sums of the first 0, 1, … n samples less the mean of all: a large constant takes no digits.
fn sums(samples: &[f64]) -> Vec<f64> {
    let mean = stats::mean(samples);
    let add = |sum: &mut f64, sample: &f64| {
        *sum += sample - mean;
        Some(*sum)
    };
    std::iter::once(0.0).chain(samples.iter().scan(0.0, add)).collect()
}

/// The Allan variance of averages of `m` samples from their sums, of which there are more than 2m.
fn variance(sums: &[f64], m: usize) -> f64 {
    let triples = sums.iter().zip(&sums[m..]).zip(&sums[2 * m..]);
    let squares: f64 =
        triples.map(|((start, middle), end)| ((end - middle) - (middle - start)).powi(2)).sum();
    squares / (2.0 * (m as f64).powi(2) * (sums.len() - 2 * m) as f64)
}

/// Equivalent degrees of freedom of averages of `m` samples that have N = `sums` sums; at most the pairs:
///
/// - α = 0: (3(N − 1)/(2m) − 2(N − 2)/N) · 4m²/(4m² + 5),
/// - α = 1: 5N²/(4m(N + 3m)), and for m = 1 2(N − 2)²/(2.3N − 4.9),
/// - α = 2: (N − 2)/m · ((N − 1)² − 3m(N − 1) + 4m²)/(N − 3)².
fn freedom(sums: usize, m: usize, exponent: f64) -> f64 {
    if exponent.is_nan() {
        return f64::NAN;
    }
    let pairs = (sums - 2 * m) as f64;
    let (n, m) = (sums as f64, m as f64);
    let table = match exponent.round() {
        ..=0.0 => (1.5 * (n - 1.0) / m - 2.0 * (n - 2.0) / n) * 4.0 * m * m / (4.0 * m * m + 5.0),
        ..=1.0 if m == 1.0 => 2.0 * (n - 2.0).powi(2) / (2.3 * n - 4.9),
        ..=1.0 => 5.0 * n * n / (4.0 * m * (n + 3.0 * m)),
        _ => (n - 2.0) / m * ((n - 1.0).powi(2) - 3.0 * m * (n - 1.0) + 4.0 * m * m) / (n - 3.0).powi(2),
    };
    table.min(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_test_sets() {
        // W. J. Riley, NIST Special Publication 1065 (2008), sets of 9 and of 1000 frequencies; the first is from
        // NBS Monograph 140, Annex 8.E, the second n/(2³¹ − 1), n' = 16807 n mod (2³¹ − 1).
        let nine = [892.0, 809.0, 823.0, 798.0, 671.0, 644.0, 883.0, 903.0, 677.0];
        let modulus = (1_u64 << 31) - 1;
        let numbers = std::iter::successors(Some(1_234_567_890_u64), |n| Some(16_807 * n % modulus));
        let thousand: Vec<f64> = numbers.take(1000).map(|n| n as f64 / modulus as f64).collect();
        for (samples, m, printed) in [
            (&nine[..], 1, "9.122945e1"),
            (&nine, 2, "8.595287e1"),
            (&thousand, 1, "2.922319e-1"),
            (&thousand, 10, "9.159953e-2"),
            (&thousand, 100, "3.241343e-2"),
        ] {
            assert_eq!(format!("{:.6e}", variance(&sums(samples), m).sqrt()), printed, "m = {m}");
        }
    }

    #[test]
    fn a_large_constant_takes_no_digits() {
        // Noise of 0.01 in steps of 2⁻²⁰, so that 50 000 more leaves the samples exact.
        let unit = (1_u32 << 20) as f64;
        let mut stream = noise::Stream::new(5, "constant");
        let noise: Vec<f64> = (0..200_000).map(|_| (0.01 * stream.normal() * unit).round() / unit).collect();
        let lifted: Vec<f64> = noise.iter().map(|x| x + 50_000.0).collect();
        for m in [1, 64, 4096, 50_000] {
            let ratio = variance(&sums(&lifted), m) / variance(&sums(&noise), m);
            assert!((ratio.sqrt() - 1.0).abs() < 1e-11, "m = {m}: {ratio}");
        }
    }
}
