//! A body that still air warms.

use super::ode;
use crate::signal::Signal;

/// Temperature of a body whose heat goes by natural convection, degC at given times; in balance with the air
/// at the first of them:
///
/// ```text
/// τ dx/dt = (T − x) |(T − x) / 1 K|^(1/4)
/// ```
///
/// τ is the time constant at a difference of 1 K: the smaller the difference, the later the body. Source:
/// Incropera and DeWitt, Fundamentals of Heat and Mass Transfer, chapter 9 (laminar flow).
pub fn body(air: &Signal, times: &[f64], tau_s: f64) -> Vec<f64> {
    let Some(&from) = times.first() else { return Vec::new() };
    let states = ode::march(from, [air(from)], times, 0.05 * tau_s, |t, x| {
        let colder = air(t) - x[0];
        [colder * colder.abs().powf(0.25) / tau_s]
    });
    states.iter().map(|x| x[0]).collect()
}

/// Temperature over still air of a body that power p warms, in units of what a steady power of 1 gives, at
/// given times:
///
/// ```text
/// τ dx/dt = p − x |x|^(1/4)
/// ```
///
/// cold at the first of the times; a steady power warms it by p^(4/5). Source as above.
pub fn heated(power: &Signal, times: &[f64], tau_s: f64) -> Vec<f64> {
    let Some(&from) = times.first() else { return Vec::new() };
    let states = ode::march(from, [0.0], times, 0.1 * tau_s, |t, x: &[f64; 1]| {
        [(power(t) - x[0] * x[0].abs().powf(0.25)) / tau_s]
    });
    states.iter().map(|x| x[0]).collect()
}

/// Share of its warmth that a body in still air has not yet come to, a time after it is switched on with a
/// power of 1: 1 − x of [`heated`].
pub fn missing(times: &[f64], tau_s: f64) -> Vec<f64> {
    let steps: Vec<f64> = std::iter::once(0.0).chain(times.iter().copied()).collect();
    let on: Signal = std::sync::Arc::new(|_| 1.0);
    heated(&on, &steps, tau_s).into_iter().skip(1).map(|x| 1.0 - x).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// Cooling from a difference d: (d^(−1/4) + t/4τ)^(−4).
    #[test]
    fn it_cools_as_the_closed_form_has_it() {
        let (tau, step): (f64, Signal) = (100.0, Arc::new(|t| if t <= 0.0 { 8.0 } else { 0.0 }));
        let times: Vec<f64> = (0..40).map(|k| 10.0 * f64::from(k)).collect();
        for (t, x) in times.iter().zip(body(&step, &times, tau)) {
            let exact = (8.0_f64.powf(-0.25) + t / (4.0 * tau)).powi(-4);
            assert!((x - exact).abs() < 0.12, "{t}: {x} for {exact}");
        }
    }

    /// A steady power warms by its power of 4/5; in the beginning the warmth rises by p t/τ.
    #[test]
    fn a_steady_power_warms_by_its_known_power() {
        for power in [0.2_f64, 1.0, 3.0] {
            let steady: Signal = Arc::new(move |_| power);
            let found = heated(&steady, &[0.0, 0.01, 5_000.0], 50.0);
            assert!((found[1] / (power * 0.01 / 50.0) - 1.0).abs() < 0.01, "{}", found[1]);
            assert!((found[2] - power.powf(0.8)).abs() < 1e-9, "{}", found[2]);
        }
        let missing = missing(&[0.0, 5_000.0], 50.0);
        assert!((missing[0] - 1.0).abs() < 1e-12 && missing[1].abs() < 1e-9);
    }
}
