//! Bodies that warm each other.

use super::ode;
use crate::signal::Signal;

/// Temperature of a core behind a former behind a thermometer, degC at given times; in equilibrium with the
/// first of them:
///
/// ```text
/// τ_f dT_f/dt = (T − T_f) + ρ (T_c − T_f),   τ_c dT_c/dt = T_f − T_c
/// ```
///
/// ρ: how well the former feels the core, against how well it feels the thermometer's housing. Newton's law
/// of cooling for two lumped bodies; Incropera and DeWitt, Fundamentals of Heat and Mass Transfer, chapter 5.
pub fn core(thermometer: &Signal, times: &[f64], former_s: f64, core_s: f64, back: f64) -> Vec<f64> {
    let Some(&from) = times.first() else { return Vec::new() };
    let begin = [thermometer(from); 2];
    let largest = 0.2 * former_s.min(core_s) / (1.0 + back);
    let states = ode::march(from, begin, times, largest, |t, x| {
        [(thermometer(t) - x[0] + back * (x[1] - x[0])) / former_s, (x[0] - x[1]) / core_s]
    });
    states.iter().map(|x| x[1]).collect()
}

/// Excess temperature of a coil's former over what it has without current, in units of what a steady ampere
/// gives:
///
/// ```text
/// τ_w dW/dt = I² − (W − F) κ,   τ_f dF/dt = (W − F) κ − F
/// ```
///
/// W the winding, F the former, κ how well the two touch. The current has flowed as at `from` long before.
/// Copper's resistance rises by 0.39 % per K, which is left out: the supply keeps the current, and a K of
/// warming changes the heat by as much.
pub fn former_of_coil(
    current_a: &Signal,
    from: f64,
    times: &[f64],
    winding_s: f64,
    former_s: f64,
) -> Vec<f64> {
    const TOUCH: f64 = 4.0;
    let steady = current_a(from).powi(2);
    let begin = [steady * (1.0 + 1.0 / TOUCH), steady];
    let states = ode::march(from, begin, times, 0.2 * winding_s.min(former_s) / TOUCH, |t, x| {
        let through = (x[0] - x[1]) * TOUCH;
        [(current_a(t).powi(2) - through) / winding_s, (through - x[1]) / former_s]
    });
    states.iter().map(|x| x[1]).collect()
}

/// Warmth of an electronics box after it is switched on at time 0, 0 to 1, with losses by conduction and by
/// radiation:
///
/// ```text
/// τ dx/dt = (1 + ε) − x − ε x (1 + x) / 2
/// ```
///
/// The share ε of the losses goes by radiation, to second order in the rise.
pub fn box_after_switch_on(times: &[f64], tau_s: f64, radiated: f64) -> Vec<f64> {
    let states = ode::march(0.0, [0.0], times, 0.05 * tau_s, |_, x| {
        [(1.0 + radiated - x[0] - radiated * x[0] * (1.0 + x[0]) / 2.0) / tau_s]
    });
    states.iter().map(|x| x[0]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// Without heat flowing back the two lags in a row have a closed form.
    #[test]
    fn a_ramp_through_two_lags() {
        let (a, b) = (30.0_f64, 90.0_f64);
        let ramp: Signal = Arc::new(|t| t);
        let times: Vec<f64> = (0..60).map(|k| 10.0 * f64::from(k)).collect();
        for (t, x) in times.iter().zip(core(&ramp, &times, a, b, 0.0)) {
            let exact = t - a - b + (a * a * (-t / a).exp() - b * b * (-t / b).exp()) / (a - b);
            assert!((x - exact).abs() < 1e-3, "{t}: {x} for {exact}");
        }
    }

    #[test]
    fn a_held_current_warms_by_its_square() {
        let current: Signal = Arc::new(|t| if t > 0.0 { 2.0 } else { 0.0 });
        let end = former_of_coil(&current, 0.0, &[20_000.0], 30.0, 600.0);
        assert!((end[0] - 4.0).abs() < 1e-6, "{}", end[0]);
        let held: Signal = Arc::new(|_| 1.5);
        let still = former_of_coil(&held, 0.0, &[10.0, 500.0], 30.0, 600.0);
        assert!(still.iter().all(|x| (x - 2.25).abs() < 1e-9));
    }

    #[test]
    fn a_box_warms_to_one_and_without_radiation_exponentially() {
        let times = [0.0, 100.0, 700.0, 20_000.0];
        for (t, x) in times.iter().zip(box_after_switch_on(&times, 700.0, 0.0)) {
            assert!((x - (1.0 - (-t / 700.0).exp())).abs() < 1e-6);
        }
        assert!((box_after_switch_on(&times, 700.0, 0.3)[3] - 1.0).abs() < 1e-6);
    }
}
