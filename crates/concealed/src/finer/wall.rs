//! Heat that diffuses through a wall.

use super::ode;
use crate::signal::Signal;

/// Cells that the wall is cut into.
const CELLS: usize = 12;

/// Temperature at the inner, insulated face of a wall whose outer face follows a signal, in the signal's
/// unit:
///
/// ```text
/// ∂T/∂t = D ∂²T/∂x²,   T(0) = s,   ∂T/∂x(L) = 0,   τ = 4 L² / (π² D)
/// ```
///
/// in twelve cells, in balance with the signal at the first of the times. A slow course comes out late by
/// L²/2D = τ π²/8. Source: Carslaw and Jaeger 1959, Conduction of Heat in Solids, section 3.4.
pub fn inner_face(signal: &Signal, times: &[f64], tau_s: f64) -> Vec<f64> {
    let Some(&from) = times.first() else { return Vec::new() };
    let cells = CELLS as f64;
    // D/h² of a cell of width h = L/12, per s.
    let rate = cells * cells * 4.0 / (std::f64::consts::PI.powi(2) * tau_s);
    let states = ode::march(from, [signal(from); CELLS], times, 0.5 / rate, |t, x| {
        let outside = signal(t);
        std::array::from_fn(|k| {
            // The outer face is half a cell from the middle of the first.
            let before = if k == 0 { 2.0 * (outside - x[0]) } else { x[k - 1] - x[k] };
            let behind = if k + 1 < CELLS { x[k + 1] - x[k] } else { 0.0 };
            rate * (before + behind)
        })
    });
    states.iter().map(|x| x[CELLS - 1]).collect()
}

/// By what a slow course comes out late, s.
pub fn mean_lag(tau_s: f64) -> f64 {
    tau_s * std::f64::consts::PI.powi(2) / 8.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use std::sync::Arc;

    /// A step: 1 − Σ 4 (−1)^k / ((2k+1) π) exp(−(2k+1)² t/τ).
    #[test]
    fn a_step_goes_through_as_the_analytic_solution_has_it() {
        let (tau, step): (f64, Signal) = (50.0, Arc::new(|t| if t > 0.0 { 1.0 } else { 0.0 }));
        let times: Vec<f64> = (0..60).map(|k| 3.0 * f64::from(k)).collect();
        for (t, found) in times.iter().zip(inner_face(&step, &times, tau)).skip(1) {
            let mode = |k: i32| {
                let n = f64::from(2 * k + 1);
                f64::from(1 - 2 * (k % 2)) * 4.0 / (n * PI) * (-n * n * t / tau).exp()
            };
            let exact = 1.0 - (0..200).map(mode).sum::<f64>();
            assert!((found - exact).abs() < 0.01, "{t}: {found} for {exact}");
        }
    }

    #[test]
    fn a_ramp_is_late_by_the_mean_lag() {
        let ramp: Signal = Arc::new(|t| t);
        let found = inner_face(&ramp, &[0.0, 3000.0], 60.0);
        assert!((3000.0 - found[1] - mean_lag(60.0)).abs() < 1.0, "{}", found[1]);
    }
}
