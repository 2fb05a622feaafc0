use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};

use crate::least_squares::above;

/// One Ornstein–Uhlenbeck process: covariance s² exp(−λ|τ|).
///
/// In a sum, s² may be negative; what counts is that the density of the whole sum is not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Process {
    /// s², nT².
    pub variance_nt2: f64,
    /// λ, 1/s: 2π times its corner frequency.
    pub rate_per_s: f64,
}

impl Process {
    /// One-sided density at a frequency, nT²/Hz: 4 s² λ/(λ² + (2πf)²).
    pub fn density(&self, frequency_hz: f64) -> f64 {
        let rate = self.rate_per_s;
        4.0 * self.variance_nt2 * rate / (rate * rate + (2.0 * PI * frequency_hz).powi(2))
    }

    /// One-sided density of its readings `step_s` apart (with what is folded down from above the Nyquist
    /// frequency), nT²/Hz: 2 Δt s² (1 − φ²)/(1 − 2 φ cos 2πfΔt + φ²), φ = exp(−λΔt).
    pub fn sampled_density(&self, frequency_hz: f64, step_s: f64) -> f64 {
        let product = self.rate_per_s * step_s;
        let (left, kept) = (-(-product).exp_m1(), (-product).exp());
        let sine = (PI * frequency_hz * step_s).sin();
        -2.0 * step_s * self.variance_nt2 * (-2.0 * product).exp_m1()
            / (left * left + 4.0 * kept * sine * sine)
    }
}

/// Corner frequencies in cycles a step: five about the Nyquist frequency, from the first downwards, each a
/// part of the one above; from there on two in each decade.
const FASTEST: f64 = 2.0;
const FAST: usize = 5;
const FAST_RATIO: f64 = 1.7;
/// The slowest corner is at this part of the lowest frequency: below, the density levels off.
pub const SLOWEST: f64 = 0.2;
/// Weight of errors in the last octave, where a power law folded at Nyquist has a kink.
const LAST_OCTAVE: f64 = 0.1;
/// The density is at least this part of the power law everywhere (of f⁻² beyond Nyquist).
const LEAST: f64 = 0.01;
/// Pulls needless weights to zero.
const RIDGE: f64 = 1e-5;
/// Fewest steps that the lowest frequency may take.
const FEWEST: f64 = 16.0;

/// Power-law noise A f^-α (nT²/Hz) as a sum of Ornstein–Uhlenbeck processes and a white part (variance of a
/// reading, nT²), for readings `step_s` apart and frequencies from 1/`oldest_s` to 1/(2 `step_s`).
///
/// An endless sum with s_j² = A sin(πα/2) h ν_j^(1−α), ν_j the corner frequencies and h the step of ln ν, has
/// this density but for a ripple (van der Ziel 1950; Milotti 1995, Phys. Rev. E 51, 3087). Few processes, and
/// what sampling folds down, spoil its ends. So the s_j² are those of the least squares of the relative
/// errors of the *sampled* density over the logarithm of the frequency. They may be negative, but the density
/// of the sum is positive at every frequency, and therefore its covariance is one at any times (Bochner), not
/// only at even ones. Below the band the density levels off.
pub fn sum(amplitude: f64, exponent: f64, step_s: f64, oldest_s: f64) -> (Vec<Process>, f64) {
    if amplitude <= 0.0 {
        return (Vec::new(), 0.0);
    }
    if exponent < 1e-6 {
        return (Vec::new(), amplitude / (2.0 * step_s));
    }
    // In units of the step, A = 1.
    let lowest = 1.0 / (oldest_s / step_s).max(FEWEST);
    let corners = corners(lowest);
    let weights = weights(&corners, exponent, lowest);
    let scale = amplitude * step_s.powf(exponent - 1.0);
    let process = |(corner, weight): (&f64, &f64)| Process {
        variance_nt2: scale * weight,
        rate_per_s: 2.0 * PI * corner / step_s,
    };
    (corners.iter().zip(weights.iter()).map(process).collect(), scale * weights[corners.len()].max(0.0))
}

fn corners(lowest: f64) -> Vec<f64> {
    let mut corner = FASTEST;
    let mut corners = vec![corner];
    while corner > SLOWEST * lowest {
        corner /= if corners.len() < FAST { FAST_RATIO } else { 10f64.sqrt() };
        corners.push(corner);
    }
    corners
}

/// From one frequency to another, `each` in a decade.
fn spread(from: f64, to: f64, each: f64) -> impl Iterator<Item = f64> {
    let count = ((to / from).log10() * each).ceil();
    (0..=count as usize).map(move |number| from * (to / from).powf(number as f64 / count))
}

/// Variances of the processes, then that of the white part, for A = 1 and readings one apart.
fn weights(corners: &[f64], exponent: f64, lowest: f64) -> DVector<f64> {
    let (nyquist, white) = (0.5f64, corners.len());
    // Sizes of about one for what is unknown.
    let mut sizes: Vec<f64> = corners.iter().map(|corner| corner.powf(1.0 - exponent)).collect();
    sizes.push(nyquist.powf(-exponent));
    let unit =
        |column: usize| Process { variance_nt2: sizes[column], rate_per_s: 2.0 * PI * corners[column] };

    let band: Vec<f64> = spread(lowest, nyquist, 16.0).collect();
    let mut errors = DMatrix::zeros(band.len() + white + 1, white + 1);
    let mut wanted = DVector::zeros(errors.nrows());
    for (row, f) in band.iter().enumerate() {
        wanted[row] = if *f > 0.52 * nyquist { LAST_OCTAVE } else { 1.0 };
        let relative = wanted[row] * f.powf(exponent);
        for column in 0..white {
            errors[(row, column)] = unit(column).sampled_density(*f, 1.0) * relative;
        }
        errors[(row, white)] = 2.0 * sizes[white] * relative;
    }
    (0..=white).for_each(|column| errors[(band.len() + column, column)] = RIDGE);

    // The density relative to the power law at frequencies from none to all, and the white part.
    let slow = spread(0.01 * lowest, 0.1, 12.0);
    let everywhere: Vec<f64> = [0.0].into_iter().chain(slow).chain(spread(0.1, 1e4, 48.0)).collect();
    let mut bounds = DMatrix::zeros(everywhere.len() + 1, white + 1);
    let mut least = DVector::from_element(everywhere.len() + 1, LEAST);
    for (row, f) in everywhere.iter().enumerate() {
        let law = f.clamp(lowest, nyquist).powf(-exponent) * (nyquist / f.max(nyquist)).powi(2);
        for column in 0..white {
            bounds[(row, column)] = unit(column).density(*f) / law;
        }
    }
    bounds[(everywhere.len(), white)] = 1.0;
    least[everywhere.len()] = 0.0;
    // There always is a sum above the bounds: one of large and positive parts.
    let found = above(&errors, &wanted, &bounds, &least).expect("weights above the bounds");
    DVector::from_iterator(white + 1, found.iter().zip(&sizes).map(|(weight, size)| weight * size))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_follow_power_laws() {
        for exponent in [1e-5, 0.02, 0.1, 0.5, 0.8, 1.0, 1.3, 1.5, 1.8, 2.0] {
            for steps in [5.0, 100.0, 3000.0, 1e6, 1e10] {
                let (processes, white) = sum(1.0, exponent, 1.0, steps);
                let farthest = |from: f64, to: f64| {
                    let error = |f: f64| {
                        let sampled: f64 = processes.iter().map(|p| p.sampled_density(f, 1.0)).sum();
                        ((sampled + 2.0 * white) * f.powf(exponent) - 1.0).abs()
                    };
                    spread(from, to, 150.0).map(error).fold(0.0, f64::max)
                };
                let (below, last) = (farthest(1.0 / steps.max(16.0), 0.25), farthest(0.25, 0.5));
                assert!(below < 0.007, "{exponent} {steps}: {below}");
                assert!(last < 0.15, "{exponent} {steps}: {last}");
                // The density is positive everywhere, to the limit f⁻² Σ s² λ/π².
                for f in spread(1e-4 / steps, 1e6, 200.0) {
                    let density: f64 = processes.iter().map(|p| p.density(f)).sum();
                    assert!(density > 0.0, "{exponent} {steps} {f}");
                }
                assert!(processes.iter().map(|p| p.variance_nt2 * p.rate_per_s).sum::<f64>() > 0.0);
            }
        }
    }

    #[test]
    fn amplitude_and_step_scale() {
        let (unit, white) = sum(1.0, 0.7, 1.0, 1e4);
        let (processes, scaled) = sum(3.0, 0.7, 0.02, 200.0);
        let density =
            |f: f64| processes.iter().map(|p| p.sampled_density(f, 0.02)).sum::<f64>() + 0.04 * scaled;
        let expected =
            |f: f64| unit.iter().map(|p| p.sampled_density(f * 0.02, 1.0)).sum::<f64>() + 2.0 * white;
        for f in [0.005, 0.3, 10.0] {
            assert!((density(f) * f.powf(0.7) / 3.0 - 1.0).abs() < 0.007);
            let scale = 3.0 * 0.02f64.powf(0.7);
            assert!((density(f) / (scale * expected(f)) - 1.0).abs() < 1e-9);
        }
    }
}
