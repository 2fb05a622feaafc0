//! A body that still air warms.

use super::ode;
use crate::signal::Signal;

/// Temperature of a body whose heat goes by natural convection, degC at given times; in balance with the air at the first of them:
///
/// ```text
/// τ dx/dt = (T − x) |(T − x) / 1 K|^(1/4)
/// ```
///
/// τ is the time constant at a difference of 1 K: the smaller the difference, the later the body. Source: Incropera and DeWitt, Fundamentals
/// of Heat and Mass Transfer, chapter 9 (laminar flow).
pub fn body(air: &Signal, times: &[f64], tau_s: f64) -> Vec<f64> {
    let Some(&from) = times.first() else { return Vec::new() };
    let states = ode::march(from, [air(from)], times, 0.05 * tau_s, |t, x| {
        let colder = air(t) - x[0];
        [colder * colder.abs().powf(0.25) / tau_s]
    });
    states.iter().map(|x| x[0]).collect()
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
}
