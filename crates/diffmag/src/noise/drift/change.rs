use common::{DriftChange, Quantity};
use estimate::stats;
use std::f64::consts::PI;

use paired::noise::Noise;

/// Turns of the sine over which the integral is summed; beyond, sin² is a half.
const TURNS: f64 = 30.0;
const POINTS: usize = 4000;

/// The change of d over a span by the drift, `drift_nt` with its standard uncertainty and that one's degrees
/// of freedom, and by the noise; the two as independent.
pub fn change(
    span_s: f64,
    (drift_nt, std, freedom): (f64, f64, f64),
    noise: &Noise,
    (length_s, step_s): (f64, f64),
) -> DriftChange {
    let (amplitude, exponent) = noise.power_law();
    let slow = structure(amplitude, exponent, span_s, step_s);
    let known = 2.0 / noise.relative_std(0.5 / span_s).powi(2);
    let noisy = slow + 2.0 * noise.white_variance();
    let (own, all) = (std * std, std * std + noisy);
    let freedom = all * all / (own * own / freedom + slow * slow / known);
    let half = stats::coverage_factor(0.95, freedom) * all.sqrt();
    let widened = std * super::joint::widening(freedom);
    DriftChange {
        drift_nt: Quantity::new(drift_nt, widened),
        noise_rms_nt: noisy.sqrt(),
        interval_nt: [drift_nt - half, drift_nt + half],
        extrapolated: span_s > length_s,
    }
}

/// The structure function of noise A/f^α, the mean square of its change over a span s: ∫ 4 A f^-α sin²(πfs)
/// df up to the Nyquist frequency; 0 < α < 3.
fn structure(amplitude: f64, exponent: f64, span_s: f64, step_s: f64) -> f64 {
    // With u = f s = v² the integrand is smooth at zero.
    let end = 0.5 * span_s / step_s;
    let width = end.min(TURNS).sqrt() / POINTS as f64;
    let part = |v: f64| 8.0 * v * (v * v).powf(-exponent) * (PI * (v * v)).sin().powi(2) * width;
    let slow: f64 = (0..POINTS).map(|i| part((i as f64 + 0.5) * width)).sum();
    let beyond = exponent - 1.0;
    let fast = match (end / TURNS).ln() {
        octaves if octaves <= 0.0 => 0.0,
        octaves if beyond.abs() < 1e-9 => 2.0 * octaves,
        octaves => -2.0 * TURNS.powf(-beyond) * (-beyond * octaves).exp_m1() / beyond,
    };
    amplitude * span_s.powf(beyond) * (slow + fast)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_of_known_noise() {
        // α = 2 with A = r²/(2π²) is a random walk of r² a second, but for what is above the Nyquist
        // frequency, 2A/f_N.
        let walk = structure(1.0 / (2.0 * PI * PI), 2.0, 5000.0, 1.0);
        assert!((walk - (5000.0 - 2.0 / (PI * PI))).abs() < 0.05, "{walk}");
        // α = 1: 2A (ln(2π f_N s) + γ), γ Euler's constant, for a span of whole steps.
        for span in [7.0, 2000.0] {
            let expected = 2.0 * ((PI * span).ln() + 0.577_215_664_9);
            let flicker = structure(1.0, 1.0, span, 1.0);
            assert!((flicker - expected).abs() < 0.01, "{span}: {flicker} {expected}");
        }
        // White noise has α = 0: its change has twice its variance P f_N.
        assert!((structure(1.0, 1e-9, 100.0, 1.0) - 1.0).abs() < 1e-3);
    }
}
