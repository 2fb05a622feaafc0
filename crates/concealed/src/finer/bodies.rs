//! Bodies in a row, each warmed by the one before it.

use super::ode;
use crate::signal::Signal;

/// The last of N bodies in a row behind a signal, in its unit:
///
/// ```text
/// τ_1 dx_1/dt = s − x_1,   τ_k dx_k/dt = x_(k−1) − x_k
/// ```
///
/// It begins `before_s` ahead of the first time, in balance with the signal there. Newton's law of cooling
/// where no heat flows back; Incropera and DeWitt, Fundamentals of Heat and Mass Transfer, chapter 5. The
/// same equation holds for a signal behind several filters.
pub fn last<const N: usize>(signal: &Signal, times: &[f64], taus_s: [f64; N], before_s: f64) -> Vec<f64> {
    let Some(&first) = times.first() else { return Vec::new() };
    let from = first - before_s;
    let largest = 0.2 * taus_s.iter().copied().fold(f64::INFINITY, f64::min);
    let states = ode::march(from, [signal(from); N], times, largest, |t, x| {
        std::array::from_fn(|k| {
            let before = if k == 0 { signal(t) } else { x[k - 1] };
            (before - x[k]) / taus_s[k]
        })
    });
    states.iter().map(|x| x[N - 1]).collect()
}

/// A core that the air warms, as seen from a thermometer elsewhere that is itself late, in the thermometer's
/// unit:
///
/// ```text
/// τ_t dT/dt = A − T,   τ dx/dt = A − x,   so that x = r T + (1 − r) L,   τ dL/dt = T − L,   r = τ_t / τ
/// ```
///
/// A the air, T the thermometer; in balance with it at the first of the times.
pub fn beside_a_late_thermometer(
    thermometer: &Signal,
    times: &[f64],
    thermometer_s: f64,
    core_s: f64,
) -> Vec<f64> {
    let share = thermometer_s / core_s;
    let late = last(thermometer, times, [core_s], 0.0);
    times.iter().zip(late).map(|(t, late)| share * thermometer(*t) + (1.0 - share) * late).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// A thermometer that lags behind a sine of the air gives back the core that lags behind the same sine.
    #[test]
    fn a_late_thermometer_is_taken_into_account() {
        let (omega, late, core) = (0.05_f64, 8.0_f64, 25.0_f64);
        let lagged = move |tau: f64, t: f64| {
            ((omega * t).sin() - omega * tau * (omega * t).cos()) / (1.0 + (omega * tau).powi(2))
        };
        let thermometer: Signal = Arc::new(move |t| lagged(late, t));
        let times: Vec<f64> = (0..400).map(|k| 2.0 * f64::from(k)).collect();
        let found = beside_a_late_thermometer(&thermometer, &times, late, core);
        // What it began with is forgotten after twelve time constants.
        for (t, x) in times.iter().zip(found).skip(150) {
            assert!((x - lagged(core, *t)).abs() < 1e-3, "{t}");
        }
    }

    /// A step through three equal bodies: 1 − (1 + u + u²/2) exp(−u), u = t/τ.
    #[test]
    fn a_step_through_three_equal_bodies() {
        let step: Signal = Arc::new(|t| if t > 0.0 { 1.0 } else { 0.0 });
        let times: Vec<f64> = (0..50).map(|k| 4.0 * f64::from(k)).collect();
        for (t, x) in times.iter().zip(last(&step, &times, [30.0; 3], 0.0)) {
            let u = t / 30.0;
            let exact = 1.0 - (1.0 + u + 0.5 * u * u) * (-u).exp();
            // The first step sees the edge of the signal.
            assert!((x - exact).abs() < 2e-2, "{t}: {x} for {exact}");
        }
    }

    /// A steady rise comes out late by the sum of the time constants.
    #[test]
    fn a_ramp_is_late_by_the_sum() {
        let ramp: Signal = Arc::new(|t| t);
        let found = last(&ramp, &[2000.0], [10.0, 20.0, 40.0], 2000.0);
        assert!((found[0] - 1930.0).abs() < 1e-6, "{}", found[0]);
    }
}
