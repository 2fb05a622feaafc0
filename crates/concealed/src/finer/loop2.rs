//! The feedback loop of a fluxgate with an integrator and a filter.

use super::ode;
use crate::signal::Signal;

/// What a loop of second order makes of a field, in the field's unit, at given times:
///
/// ```text
/// y'' + 2 ζ ω y' + ω² y = ω² B
/// ```
///
/// It begins `before_s` ahead in balance with the field, and again ahead of each time that is farther from
/// the one before: what was there earlier is forgotten. Source: Franklin, Powell and Emami-Naeini, Feedback
/// Control of Dynamic Systems, section 3.3; Primdahl 1979, The fluxgate magnetometer, J. Phys. E 12, 241.
pub fn followed(field: &Signal, times: &[f64], omega: f64, damping: f64, before_s: f64) -> Vec<f64> {
    let mut last: Option<(f64, [f64; 2])> = None;
    times
        .iter()
        .map(|&time| {
            let ahead = time - before_s;
            let (from, begin) = last.filter(|(at, _)| *at > ahead).unwrap_or((ahead, [field(ahead), 0.0]));
            let slope = |t: f64, y: &[f64; 2]| {
                [y[1], omega * omega * (field(t) - y[0]) - 2.0 * damping * omega * y[1]]
            };
            let state = ode::march(from, begin, &[time], 0.2 / omega, slope)[0];
            last = Some((time, state));
            state[0]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;
    use std::sync::Arc;

    #[test]
    fn a_sine_comes_out_with_the_gain_and_phase_of_the_transfer_function() {
        let (omega, damping, drive) = (30.0, 0.7, TAU * 2.0);
        let field: Signal = Arc::new(move |t| (drive * t).sin());
        let times: Vec<f64> = (0..40).map(|k| 5.0 + 0.013 * f64::from(k)).collect();
        let found = followed(&field, &times, omega, damping, 5.0);
        let (re, im) = (omega * omega - drive * drive, 2.0 * damping * omega * drive);
        let gain = omega * omega / re.hypot(im);
        let phase = im.atan2(re);
        for (t, y) in times.iter().zip(found) {
            assert!((y - gain * (drive * t - phase).sin()).abs() < 1e-5);
        }
    }
}
