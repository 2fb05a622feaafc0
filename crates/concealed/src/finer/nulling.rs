//! The loop that cancels the natural variation in the test volume.

use super::ode;
use crate::signal::Signal;

/// What is left of a natural variation U in the test volume, in its unit. The loop's sensor stands elsewhere
/// and feels U; its integrator drives the coils until the sensor feels nothing; the test volume feels U and,
/// through the building's metal, a share g of it late:
///
/// ```text
/// dC/dt = (U − C) / τ_loop,   τ_1 dD_1/dt = U − D_1,   τ_2 dD_2/dt = D_1 − D_2,   left = U − C + g D_2
/// ```
///
/// Source: NASA CR-156638, test of the Earth field nulling system, for the arrangement; the rest is a loop
/// with one integrator.
pub fn left(
    variation: &Signal,
    times: &[f64],
    loop_s: f64,
    metal_s: [f64; 2],
    share: f64,
    before_s: f64,
) -> Vec<f64> {
    let Some(first) = times.first() else { return Vec::new() };
    let from = first - before_s;
    let largest = 0.5 * loop_s.min(metal_s[0]).min(metal_s[1]);
    let states = ode::march(from, [variation(from); 3], times, largest, |t, x| {
        let u = variation(t);
        [(u - x[0]) / loop_s, (u - x[1]) / metal_s[0], (x[1] - x[2]) / metal_s[1]]
    });
    times.iter().zip(states).map(|(t, x)| variation(*t) - x[0] + share * x[2]).collect()
}

/// What a loop with a proportional amplifier of gain G leaves of a variation V that has passed two bodies of
/// metal, per axis:
///
/// ```text
/// τ_1 dA/dt = U − A,   τ_2 dV/dt = A − V,   left = g (V + τ dV/dt),   g = 1 / (1 + G)
/// ```
///
/// to first order in g: the loop's filter τ lets the faster part through. Source: Åström and Murray 2008,
/// Feedback Systems, section 10.1.
pub fn proportional(
    variation: &Signal,
    times: &[f64],
    metal_s: [f64; 2],
    filter_s: f64,
    share: f64,
) -> Vec<f64> {
    let Some(first) = times.first() else { return Vec::new() };
    let from = first - 10.0 * metal_s[0].max(metal_s[1]);
    let largest = 0.5 * metal_s[0].min(metal_s[1]);
    let states = ode::march(from, [variation(from); 2], times, largest, |t, x: &[f64; 2]| {
        [(variation(t) - x[0]) / metal_s[0], (x[0] - x[1]) / metal_s[1]]
    });
    states.into_iter().map(|x| share * (x[1] + filter_s * (x[0] - x[1]) / metal_s[1])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// Of a ramp the integrator leaves its time constant times the slope, and the metal its share of the ramp
    /// as it was τ_1 + τ_2 before.
    #[test]
    fn of_a_ramp_it_leaves_what_control_theory_says() {
        let ramp: Signal = Arc::new(|t| 3.0 * t);
        let left = left(&ramp, &[4000.0], 2.0, [100.0, 50.0], 0.01, 4000.0);
        let expected = 3.0 * 2.0 + 0.01 * 3.0 * (4000.0 - 150.0);
        assert!((left[0] - expected).abs() < 1e-6, "{} for {expected}", left[0]);
    }

    /// Of a ramp a proportional loop leaves its share, late by the metal and early by its filter.
    #[test]
    fn of_a_ramp_a_proportional_loop_leaves_its_share() {
        let ramp: Signal = Arc::new(|t| 3.0 * t);
        let left = proportional(&ramp, &[4000.0], [100.0, 50.0], 20.0, 0.01);
        assert!((left[0] - 0.01 * 3.0 * (4000.0 - 130.0)).abs() < 0.01, "{}", left[0]);
    }
}
