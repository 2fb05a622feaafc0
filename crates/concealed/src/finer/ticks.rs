//! A loop with a digital integrator.

/// Share of the oldest value below which a sum ends.
const LEAST: f64 = 1e-9;

/// What a digital integrator that takes a share g of the error at each of its ticks makes of a signal, read
/// right after a tick:
///
/// ```text
/// y(t) = Σ_k g (1 − g)^k B(t − k T)
/// ```
///
/// with the transfer function g / (1 − (1 − g) exp(−iωT)); a slow course is late by T (1 − g) / g. Source:
/// Oppenheim and Schafer, Discrete-Time Signal Processing, section 2.5.
pub fn integrated(signal: impl Fn(f64) -> f64, t: f64, tick_s: f64, share: f64) -> f64 {
    let (mut sum, mut weight, mut k) = (0.0, share, 0.0);
    while weight > LEAST * share {
        sum += weight * signal(t - k * tick_s);
        weight *= 1.0 - share;
        k += 1.0;
    }
    sum
}

/// By what a slow course comes out late, s.
pub fn mean_lag(tick_s: f64, share: f64) -> f64 {
    tick_s * (1.0 - share) / share
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;

    #[test]
    fn a_sine_comes_out_as_the_transfer_function_has_it() {
        let (tick, share) = (0.01, 0.3);
        for omega in [3.0_f64, 40.0, 150.0] {
            let gain = share / (1.0 - (1.0 - share) * Complex::new(0.0, -omega * tick).exp());
            for t in [0.0, 0.123, 0.5] {
                let exact = (gain * Complex::new(0.0, omega * t).exp()).im;
                assert!((integrated(|t| (omega * t).sin(), t, tick, share) - exact).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_ramp_is_late_by_the_mean_lag() {
        let found = integrated(|t| t, 5.0, 0.02, 0.25);
        assert!((5.0 - found - mean_lag(0.02, 0.25)).abs() < 1e-6, "{found}");
    }
}
