//! A loop with three equal poles.

/// Steps of the integral, and the width of one in time constants.
const STEPS: usize = 60;
const STEP: f64 = 0.4;

/// What three equal lags in a row make of a signal at a time:
///
/// ```text
/// y(t) = ∫ (u² / 2) exp(−u) B(t − τ u) du
/// ```
///
/// with a mean lag of 3 τ, by trapezoids up to u = 24. Source: Oppenheim and Willsky, Signals and Systems,
/// section 2.2 (convolution).
pub fn three(signal: impl Fn(f64) -> f64, t: f64, tau_s: f64) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for k in 1..=STEPS {
        let u = STEP * k as f64;
        let weight = u * u * (-u).exp();
        sum += weight * signal(t - tau_s * u);
        weights += weight;
    }
    sum / weights
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The transfer function is 1 / (1 + i ω τ)³.
    #[test]
    fn a_sine_comes_out_as_the_transfer_function_has_it() {
        for (omega, tau) in [(20.0_f64, 1e-3), (20.0, 0.01), (5.0, 0.1)] {
            let (gain, phase) = ((1.0 + (omega * tau).powi(2)).powf(-1.5), 3.0 * (omega * tau).atan());
            for t in [0.0, 0.05, 0.3] {
                let exact = gain * (omega * t - phase).sin();
                assert!((three(|t| (omega * t).sin(), t, tau) - exact).abs() < 1e-3);
            }
        }
    }
}
