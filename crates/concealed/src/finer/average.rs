//! A converter that takes the mean over a while.

/// Points at which a mean is taken.
const POINTS: usize = 16;

/// Mean of a signal over `width_s` before a time. A sine of angular frequency ω comes out late by half of the
/// width, its amplitude times sin x / x with x = ω `width_s` / 2. Source: Kester (ed.) 2005, Data Conversion
/// Handbook (filters of converters).
pub fn mean_before(signal: impl Fn(f64) -> f64, t: f64, width_s: f64) -> f64 {
    let step = width_s / POINTS as f64;
    (0..POINTS).map(|k| signal(t - step * (k as f64 + 0.5))).sum::<f64>() / POINTS as f64
}

/// Mean of a signal over `width_s` before a time with Hann's weights, 1 − cos: a sine comes out late by half
/// of the width, its amplitude times sin x / (x (1 − (x/π)²)). Source: Harris 1978, On the use of windows for
/// harmonic analysis, Proc. IEEE 66, 51.
pub fn hann_before(signal: impl Fn(f64) -> f64, t: f64, width_s: f64) -> f64 {
    let share = |k: usize| (k as f64 + 0.5) / POINTS as f64;
    let weight = |k: usize| 1.0 - (std::f64::consts::TAU * share(k)).cos();
    (0..POINTS).map(|k| weight(k) * signal(t - width_s * share(k))).sum::<f64>() / POINTS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_comes_out_late_and_smaller() {
        let (omega, width) = (20.0_f64, 0.03);
        let x = 0.5 * omega * width;
        for t in [0.0, 0.1, 0.37] {
            let exact = x.sin() / x * (omega * t - x).sin();
            assert!((mean_before(|t| (omega * t).sin(), t, width) - exact).abs() < 1e-4);
        }
    }

    #[test]
    fn with_hanns_weights_a_sine_comes_out_late_and_smaller() {
        let (omega, width) = (35.0_f64, 0.06);
        let x = 0.5 * omega * width;
        for t in [0.0, 0.1, 0.37] {
            let gain = x.sin() / (x * (1.0 - (x / std::f64::consts::PI).powi(2)));
            let exact = gain * (omega * t - x).sin();
            assert!((hann_before(|t| (omega * t).sin(), t, width) - exact).abs() < 1e-4);
        }
    }
}
