//! Sines: of a known frequency, with the uncertainty by the noise there, and of an unknown one.

mod unknown;

pub use unknown::{Series, Strongest, power_along, power_at, sharpened, strongest};

use faer::Mat;

use crate::{Error, Svd};

/// Neighbouring frequencies on each side from which the noise is read.
const NEIGHBOURS: usize = 12;
/// Neighbours nearer than this (in units of one over the record's length) still see the sine itself.
const FIRST_NEIGHBOUR: usize = 2;

/// y(t) = a cos ωt + b sin ωt + offset + trend (t − t̄).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sine {
    /// Coefficient a of cos ωt.
    pub cos: f64,
    /// Coefficient b of sin ωt.
    pub sin: f64,
    /// Standard uncertainty of `cos` and of `sin`, from the noise near ω.
    pub std: f64,
}

/// A converter that rounds to whole codes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantiser {
    /// Width of one code.
    pub step: f64,
    /// Noise before the converter, rms; None: from the scatter beyond that of rounding.
    pub noise: Option<f64>,
}

/// Rounds of the correction for rounding; each is a small part of the one before.
const ROUNDS: usize = 20;
/// Noise below this share of a code is treated as this: the corners of the staircase are never sharp.
const LEAST_NOISE: f64 = 0.05;

/// Fits a sine of `hz` to the readings that are not NaN.
///
/// The noise of the coefficients is not taken from the scatter of single readings, which is right only
/// for white noise: it is the variance of the residual's projections on sines of up to 24 neighbouring
/// frequencies. Records shorter than a few cycles have no neighbours; there the scatter has to do.
///
/// Rounding distorts a sine in step with itself, which does not average away. With a `quantiser` whose codes
/// the readings are, its mean error at the fitted values is taken off and the fit repeated until it stands still.
pub fn fit(time_s: &[f64], values: &[f64], hz: f64, quantiser: Option<Quantiser>) -> Result<Sine, Error> {
    let rows: Vec<usize> =
        (0..values.len()).filter(|&i| values[i].is_finite() && time_s[i].is_finite()).collect();
    if rows.len() < 5 {
        return Err(Error::TooFew { found: rows.len(), unknowns: 5 });
    }
    let time: Vec<f64> = rows.iter().map(|&i| time_s[i]).collect();
    let y: Vec<f64> = rows.iter().map(|&i| values[i]).collect();
    let basis = Basis::new(&time, hz)?;
    let mut x = basis.svd.solve(&y);
    let mut corrected = y.clone();
    if let Some(quantiser) = quantiser.filter(|quantiser| are_codes(&y, quantiser.step)) {
        for _ in 0..ROUNDS {
            let fitted = basis.values(&x);
            let scatter = fitted.iter().zip(&y).map(|(f, y)| (f - y).powi(2)).sum::<f64>() / y.len() as f64;
            let beyond = (scatter - quantiser.step.powi(2) / 12.0).max(0.0).sqrt();
            let noise = quantiser.noise.unwrap_or(beyond).max(LEAST_NOISE * quantiser.step);
            let rounding = Rounding::new(quantiser.step, noise);
            if rounding.coefficients.is_empty() {
                break;
            }
            for ((corrected, y), fitted) in corrected.iter_mut().zip(&y).zip(&fitted) {
                *corrected = y - rounding.mean_error(*fitted);
            }
            let next = basis.svd.solve(&corrected);
            let moved = x.iter().zip(&next).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            x = next;
            if moved < 1e-7 * quantiser.step {
                break;
            }
        }
    }
    let fitted = basis.values(&x);
    let residual: Vec<f64> = corrected.iter().zip(&fitted).map(|(y, f)| y - f).collect();
    Ok(Sine { cos: x[0], sin: x[1], std: basis.variance(&time, &residual).sqrt() })
}

/// Whether the readings are whole codes.
fn are_codes(values: &[f64], step: f64) -> bool {
    step > 0.0 && values.iter().all(|value| (value / step - (value / step).round()).abs() < 1e-6)
}

/// The mean error of rounding to multiples of `step` behind normal noise,
/// E\[Q(s + noise)\] − s = Σ (−1)ⁿ step/(π n) e^(−2 (π n noise/step)²) sin(2π n s/step).
struct Rounding {
    step: f64,
    coefficients: Vec<f64>,
}

impl Rounding {
    fn new(step: f64, noise: f64) -> Self {
        let coefficient = |n: i32| {
            let order = f64::from(n) * std::f64::consts::PI;
            let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
            sign * step / order * (-2.0 * (order * noise / step).powi(2)).exp()
        };
        let coefficients = (1..100).map(coefficient).take_while(|c| c.abs() > 1e-9 * step).collect();
        Rounding { step, coefficients }
    }

    fn mean_error(&self, s: f64) -> f64 {
        let (first, cos) = (std::f64::consts::TAU * (s / self.step)).sin_cos();
        // sin nφ by its recurrence, 2 cos φ sin nφ = sin (n+1)φ + sin (n−1)φ.
        let (mut before, mut sine, mut sum) = (0.0, first, 0.0);
        for coefficient in &self.coefficients {
            sum += coefficient * sine;
            (before, sine) = (sine, 2.0 * cos * sine - before);
        }
        sum
    }
}

/// cos ωt, sin ωt, 1 and t at the times of readings.
pub struct Basis {
    design: Mat<f64>,
    svd: Svd,
    omega: f64,
    length: f64,
}

impl Basis {
    /// For times without gaps and a frequency.
    ///
    /// Errors: [`Error::TooFew`] where no sine is determined.
    pub fn new(time: &[f64], hz: f64) -> Result<Self, Error> {
        let n = time.len();
        let omega = std::f64::consts::TAU * hz;
        let mean = time.iter().sum::<f64>() / n as f64;
        let length = (time[n - 1] - time[0]).abs() * n as f64 / (n - 1) as f64;
        let phases: Vec<(f64, f64)> = time.iter().map(|t| (omega * t).sin_cos()).collect();
        let design = Mat::from_fn(n, 4, |row, column| match column {
            0 => phases[row].1,
            1 => phases[row].0,
            2 => 1.0,
            _ => (time[row] - mean) / length,
        });
        let svd = Svd::of(design.as_ref(), 1e-10)?;
        if svd.rank() < 4 {
            return Err(Error::TooFew { found: svd.rank(), unknowns: 4 });
        }
        Ok(Basis { design, svd, omega, length })
    }

    /// The coefficients of cos ωt and sin ωt in a series without gaps.
    pub fn cos_sin(&self, values: &[f64]) -> [f64; 2] {
        let x = self.svd.solve(values);
        [x[0], x[1]]
    }

    fn values(&self, x: &[f64]) -> Vec<f64> {
        (0..self.design.nrows()).map(|i| (0..4).map(|j| self.design[(i, j)] * x[j]).sum()).collect()
    }

    /// Variance of the coefficients of the sine.
    fn variance(&self, time: &[f64], residual: &[f64]) -> f64 {
        let n = time.len() as f64;
        let cycles = self.omega / std::f64::consts::TAU * self.length;
        let turns = FIRST_NEIGHBOUR..=NEIGHBOURS;
        let lower = turns.clone().filter(|&k| (k as f64) < cycles - 1.0).map(|k| -(k as f64)).rev();
        let upper = turns.filter(|&k| cycles + (k as f64) < 0.5 * n - 1.0).map(|k| k as f64);
        let turns: Vec<f64> = lower.chain(upper).collect();
        if turns.len() < 6 {
            let covariance = self.svd.covariance();
            let scatter = residual.iter().map(|r| r * r).sum::<f64>() / (n - 4.0);
            return scatter * 0.5 * (covariance[(0, 0)] + covariance[(1, 1)]);
        }
        // Along the turns, each reading's phase grows by the same angle.
        let mut sums = vec![(0.0, 0.0); turns.len()];
        for (t, r) in time.iter().zip(residual) {
            let angle = |turn: f64| (self.omega + std::f64::consts::TAU * turn / self.length) * t;
            let (sin_one, cos_one) = (std::f64::consts::TAU / self.length * t).sin_cos();
            let (mut sin, mut cos, mut at) = (0.0, 0.0, f64::NAN);
            for (turn, sum) in turns.iter().zip(&mut sums) {
                (sin, cos) = if *turn == at + 1.0 {
                    (sin * cos_one + cos * sin_one, cos * cos_one - sin * sin_one)
                } else {
                    angle(*turn).sin_cos()
                };
                at = *turn;
                *sum = (sum.0 + r * cos, sum.1 + r * sin);
            }
        }
        let power: f64 = sums.iter().map(|(cos, sin)| (cos * cos + sin * sin) * 2.0 / (n * n)).sum();
        power / turns.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_sine_with_gaps_and_uneven_times() {
        let time: Vec<f64> = (0..500).map(|i| i as f64 * 0.1 + 0.03 * (i as f64).sin()).collect();
        let values: Vec<f64> = time
            .iter()
            .enumerate()
            .map(|(i, t)| {
                let phase = std::f64::consts::TAU * 0.3 * t;
                if i % 17 == 3 { f64::NAN } else { 3.0 * phase.cos() - 4.0 * phase.sin() + 7.0 + 0.01 * t }
            })
            .collect();
        let sine = fit(&time, &values, 0.3, None).expect("a fit");
        assert!((sine.cos - 3.0).abs() < 1e-11 && (sine.sin + 4.0).abs() < 1e-11);
        assert!(sine.std < 1e-11);
    }

    #[test]
    fn less_than_a_cycle_is_refused_only_when_it_says_nothing() {
        let time: Vec<f64> = (0..50).map(f64::from).collect();
        assert!(fit(&time, &vec![1.0; 50], 0.0, None).is_err(), "no frequency, no sine");
    }

    #[test]
    fn mean_error_of_rounding_by_counting() {
        // By the normal law over the codes: Σ k (Φ((k + ½ − s)/σ) − Φ((k − ½ − s)/σ)) − s.
        let sigma = 0.2;
        let below = |z: f64| 1.0 - 0.5 * crate::stats::two_sided_p(z.abs(), f64::INFINITY);
        let phi = |z: f64| if z >= 0.0 { below(z) } else { 1.0 - below(z) };
        for s in [0.0, 0.1, 0.37, 0.5, 0.8, -1.3] {
            let mean: f64 = (-6..=6)
                .map(f64::from)
                .map(|k| k * (phi((k + 0.5 - s) / sigma) - phi((k - 0.5 - s) / sigma)))
                .sum();
            assert!((Rounding::new(1.0, sigma).mean_error(s) - (mean - s)).abs() < 1e-9, "{s}");
            assert!((Rounding::new(3.0, 3.0 * sigma).mean_error(3.0 * s) - 3.0 * (mean - s)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_sine_of_a_few_codes_is_not_bent_by_rounding() {
        // Amplitude 5.3 codes without any noise, the peaks between two edges of a code.
        let time: Vec<f64> = (0..20_000).map(|i| f64::from(i) * 0.0123).collect();
        let codes: Vec<f64> =
            time.iter().map(|t| (5.3 * (std::f64::consts::TAU * 0.2 * t).sin() + 0.07).round()).collect();
        let quantiser = Quantiser { step: 1.0, noise: None };
        let plain = fit(&time, &codes, 0.2, None).expect("a fit");
        let corrected = fit(&time, &codes, 0.2, Some(quantiser)).expect("a fit");
        assert!((plain.sin - 5.3).abs() > 0.03, "{}", plain.sin);
        assert!((corrected.sin - 5.3).abs() < 0.006, "{}", corrected.sin);
    }
}
