//! Lags of unlike time constants beside each other.

use super::ode;
use crate::signal::Signal;

/// A sum of lags beside each other, in the signal's unit, each given as its weight and its time constant, s:
///
/// ```text
/// y = Σ_k w_k x_k,   τ_k dx_k/dt = s − x_k
/// ```
///
/// It begins `before_s` ahead of the first time, in balance with the signal there. Kelvin and Voigt's
/// elements in a row for a glue that creeps (Findley, Lai and Onaran 1976, Creep and Relaxation of Nonlinear
/// Viscoelastic Materials), or rings of metal about a coil.
pub fn lags<const N: usize>(
    signal: &Signal,
    times: &[f64],
    lags: [(f64, f64); N],
    before_s: f64,
) -> Vec<f64> {
    let Some(&first) = times.first() else { return Vec::new() };
    let from = first - before_s;
    let largest = 0.2 * lags.iter().map(|(_, tau)| *tau).fold(f64::INFINITY, f64::min);
    let states = ode::march(from, [signal(from); N], times, largest, |t, x| {
        let now = signal(t);
        std::array::from_fn(|k| (now - x[k]) / lags[k].1)
    });
    states.iter().map(|x| x.iter().zip(&lags).map(|(x, (weight, _))| weight * x).sum()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// A sine through each lag has the gain 1 / (1 + ω²τ²) and the phase of its own.
    #[test]
    fn a_sine_is_the_sum_of_its_transfer_functions() {
        let (omega, parts) = (0.2_f64, [(0.7, 3.0), (0.3, 20.0)]);
        let sine: Signal = Arc::new(move |t| (omega * t).sin());
        let times: Vec<f64> = (0..30).map(|k| 1.3 * f64::from(k)).collect();
        for (t, found) in times.iter().zip(lags(&sine, &times, parts, 400.0)) {
            let part = |(weight, tau): (f64, f64)| {
                weight * ((omega * t).sin() - omega * tau * (omega * t).cos()) / (1.0 + (omega * tau).powi(2))
            };
            let exact: f64 = parts.into_iter().map(part).sum();
            assert!((found - exact).abs() < 1e-4, "{t}: {found} for {exact}");
        }
    }
}
