//! Fields that diffuse through metal.

use super::ode;
use crate::signal::Signal;

/// Modes that are kept: 1, 3, … 15. What is left out is 5 % of the share at once, and gone after a hundredth
/// of the time constant.
const MODES: usize = 8;

/// Mean field within a plate of metal whose surfaces feel a signal, in the signal's unit:
///
/// ```text
/// D = Σ_n w_n L_n,   τ_n dL_n/dt = B − L_n,   w_n = 8 / (π n)²,   τ_n = τ / n²,   n = 1, 3, 5, …
/// ```
///
/// τ = μ₀ σ d² / π² for a plate of thickness d; weights are scaled to a sum of 1. Source: Carslaw and Jaeger
/// 1959, Conduction of Heat in Solids, section 3.3 (the same equation); Bozorth 1951, Ferromagnetism, on eddy
/// currents.
pub fn within(signal: &Signal, times: &[f64], tau_s: f64, before_s: f64) -> Vec<f64> {
    let Some(first) = times.first() else { return Vec::new() };
    let odd: [f64; MODES] = std::array::from_fn(|k| (2 * k + 1) as f64);
    let sum: f64 = odd.iter().map(|n| 1.0 / (n * n)).sum();
    let from = first - before_s;
    let begin = [signal(from); MODES];
    // Half of the fastest time constant: well inside the method's region of stability.
    let largest = 0.5 * tau_s / (odd[MODES - 1] * odd[MODES - 1]);
    let states = ode::march(from, begin, times, largest, |t, l| {
        let field = signal(t);
        std::array::from_fn(|k| (field - l[k]) * odd[k] * odd[k] / tau_s)
    });
    states.iter().map(|l| (0..MODES).map(|k| l[k] / (odd[k] * odd[k])).sum::<f64>() / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use std::sync::Arc;

    /// A step: the modes' sum against the series of the whole plate, and against √t in the beginning.
    #[test]
    fn a_step_goes_in_as_the_analytic_solution_has_it() {
        let tau = 40.0;
        let step: Signal = Arc::new(|t| if t > 0.0 { 1.0 } else { 0.0 });
        let times: Vec<f64> = (1..40).map(|k| 2.0 * f64::from(k)).collect();
        let found = within(&step, &times, tau, times[0]);
        for (t, d) in times.iter().zip(&found) {
            let exact: f64 = 1.0
                - (0..400)
                    .map(|k| {
                        let n = f64::from(2 * k + 1);
                        8.0 / (PI * n).powi(2) * (-n * n * t / tau).exp()
                    })
                    .sum::<f64>();
            // The modes left out hold 2.5 % of the field, which the others share.
            assert!((d - exact).abs() < 0.026, "{t}: {d} for {exact}");
        }
        let early = found[0];
        let root = 4.0 * (2.0 / (tau * PI.powi(3))).sqrt();
        assert!((early - root).abs() < 0.03, "{early} for {root}");
    }

    #[test]
    fn a_slow_field_lags_by_its_mean_time() {
        let ramp: Signal = Arc::new(|t| t);
        let found = within(&ramp, &[1000.0], 40.0, 1000.0);
        // Σ w_n τ_n = τ π²/12 of the whole plate.
        assert!((1000.0 - found[0] - 40.0 * PI * PI / 12.0).abs() < 1.0, "{}", found[0]);
    }
}
