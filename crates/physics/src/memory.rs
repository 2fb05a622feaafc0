//! State equations of effects with memory, exact over uneven steps and gaps.

use crate::Real;

/// First-order lag τ y' = x − y over the recording's own times, with x straight between its samples:
/// over a step Δt with Δx, y₊ = x₊ − τ Δx/Δt + (y − x + τ Δx/Δt) e^(−Δt/τ).
///
/// A missing sample (NaN) of x is bridged by its neighbours' straight line. Before its first sample x is
/// taken as constant. `initial` is y at the first row; None: in equilibrium with x.
pub fn first_order_lag<T: Real>(time_s: &[f64], x: &[f64], tau_s: T, initial: Option<f64>) -> Vec<T> {
    let x = bridged(time_s, x);
    let Some(first) = x.first() else { return Vec::new() };
    let mut y = T::from(initial.unwrap_or(*first));
    let mut lagged = Vec::with_capacity(x.len());
    lagged.push(y);
    for row in 1..x.len() {
        let (dt, dx) = (time_s[row] - time_s[row - 1], x[row] - x[row - 1]);
        if dt > 0.0 {
            let behind = tau_s * (dx / dt);
            y = (y - x[row - 1] + behind) * (-tau_s.recip() * dt).exp() - behind + x[row];
        }
        lagged.push(y);
    }
    lagged
}

/// x with missing samples replaced: straight lines between neighbours, constant at the ends; zero if all are missing.
fn bridged(time_s: &[f64], x: &[f64]) -> Vec<f64> {
    let known: Vec<usize> = (0..x.len()).filter(|&row| x[row].is_finite()).collect();
    let mut bridged = x.to_vec();
    for row in 0..x.len() {
        if x[row].is_finite() {
            continue;
        }
        let after = known.partition_point(|&k| k < row);
        bridged[row] = match (after.checked_sub(1).map(|i| known[i]), known.get(after)) {
            (Some(a), Some(&b)) if time_s[b] > time_s[a] => {
                x[a] + (x[b] - x[a]) * (time_s[row] - time_s[a]) / (time_s[b] - time_s[a])
            }
            (Some(a), _) => x[a],
            (None, Some(&b)) => x[b],
            (None, None) => 0.0,
        };
    }
    bridged
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn step_and_ramp_by_hand() {
        // Response to a ramp of 2 units/s from equilibrium: 2 (t − τ (1 − e^(−t/τ))), whatever the steps.
        let time = [0.0, 0.1, 0.15, 1.0, 1.0, 7.5, 30.0];
        let ramp: Vec<f64> = time.iter().map(|t| 2.0 * t).collect();
        let tau = 3.0;
        for (t, y) in time.iter().zip(first_order_lag(&time, &ramp, tau, None)) {
            assert!((y - 2.0 * (t - tau * (1.0 - (-t / tau).exp()))).abs() < 1e-12);
        }
        // A constant 5 from 0: 5 (1 − e^(−t/τ)); the missing sample changes nothing.
        let level = [5.0, 5.0, f64::NAN, 5.0, 5.0, 5.0, 5.0];
        for (t, y) in time.iter().zip(first_order_lag(&time, &level, tau, Some(0.0))) {
            assert!((y - 5.0 * (1.0 - (-t / tau).exp())).abs() < 1e-12);
        }
    }

    #[test]
    fn a_very_short_lag_follows() {
        let time = [0.0, 1.0, 2.0];
        let y = first_order_lag::<f64>(&time, &[1.0, 4.0, 2.0], 1e-9, None);
        assert!((y[1] - 4.0).abs() < 1e-7 && (y[2] - 2.0).abs() < 1e-7);
    }
}
