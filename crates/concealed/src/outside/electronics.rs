//! In the electronics and the logger.

use std::f64::consts::TAU;

use super::means::{in_one, mean};
use crate::draw::Draw;
use crate::effect::Effect;
use crate::finer::ode;
use crate::scene::{Campaign, Run};
use crate::signal::wandering;

/// Field to which relative errors of the sensitivity belong, nT.
const FULL_NT: f64 = 50_000.0;
/// Share of the largest field beyond which a loop rings.
const RINGS_FROM: f64 = 0.5;
/// Share of the largest field at which a relay toggles.
const TOGGLES_AT: f64 = 0.2;

/// The largest field along a sensor in any row, nT.
fn largest(campaign: &Campaign, sensor: usize) -> f64 {
    let along =
        campaign.runs.iter().flat_map(|run| run.times.iter().map(|t| run.along(&campaign.bench, sensor, *t)));
    along.fold(0.0, |largest, field| largest.max(field.abs()))
}

/// The phase of a beat, rad: 2π ∫ (1 + growth · load) dt / period.
fn beating(times: &[f64], load: impl Fn(f64) -> f64, period: f64, growth: f64) -> Vec<f64> {
    let (Some(first), [second, ..]) = (times.first(), &times[1.min(times.len())..]) else {
        return vec![0.0; times.len()];
    };
    let turns = |t: f64, _: &[f64; 1]| [TAU / period * (1.0 + growth * load(t))];
    ode::march(*first, [0.0], times, 0.3 * (second - first), turns).iter().map(|phase| phase[0]).collect()
}

/// A harmonic of the excitation beats with a switching supply, whose frequency rises with the load of the
/// coils.
///
/// ```text
/// dB = s sin(phi + phi_0), dphi/dt = 2π (1 + a L) / P, L = (I_x² + I_y² + I_z²) / 3
/// ```
///
/// dB and s in nT, currents in A, P between 7 and 12 readings, a between 1 and 2 per A².
///
/// Source: Erickson and Maksimović 2001, Fundamentals of Power Electronics (converters whose frequency
/// depends on the load).
pub fn beat(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let period = campaign.runs[0].step_s() * draw.between(7.0, 12.0);
    let (growth, begin) = (draw.between(1.0, 2.0), draw.between(0.0, TAU));
    in_one("beat with a supply whose frequency follows its load", draw, move |_, run, _, size| {
        let load =
            |t: f64| (0..3).filter_map(|coil| run.current(coil)).map(|i| i(t).powi(2)).sum::<f64>() / 3.0;
        beating(&run.times, load, period, growth).iter().map(|phase| size * (begin + phase).sin()).collect()
    })
}

/// A feedback loop that is stable in small fields and rings in large ones, where the core's gain is another.
///
/// ```text
/// dB = s √(|B| / B_r − 1) sin(2π t / P + phi_0) for |B| > B_r, else 0
/// ```
///
/// dB and s in nT, B_r half of the largest field, P the alias of the ringing, between 2.3 and 4.5 readings.
/// The amplitude grows as that of any oscillation that sets in softly.
///
/// Source: Strogatz 1994, Nonlinear Dynamics and Chaos (supercritical Hopf bifurcation).
pub fn ringing(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let period = campaign.runs[0].step_s() * draw.between(2.3, 4.5);
    let begin = draw.between(0.0, TAU);
    in_one("feedback loop that rings in large fields", draw, move |campaign, run, sensor, size| {
        let from = RINGS_FROM * largest(campaign, sensor);
        let excess = |t: f64| (run.along(&campaign.bench, sensor, t).abs() / from - 1.0).max(0.0);
        run.times.iter().map(|t| size * excess(*t).sqrt() * (TAU * t / period + begin).sin()).collect()
    })
}

/// What of a difference D is beyond what an amplifier can follow in time: sign(D) max(0, |D| / D_0 − 1).
fn unsettled(difference: f64, followed: f64) -> f64 {
    difference.signum() * (difference.abs() / followed - 1.0).max(0.0)
}

/// A multiplexer whose amplifier goes from the previous channel to this one at a limited rate: after a large
/// difference it has not arrived.
///
/// ```text
/// dB = s sign(D) max(0, |D| / D_0 − 1), D = B of the previous channel − B
/// ```
///
/// dB and s in nT, D_0 between 20 000 and 30 000 nT.
///
/// Source: Kester (ed.) 2005, Data Conversion Handbook (settling of multiplexers, slew rate).
pub fn multiplexer(_: &Campaign, draw: &mut Draw) -> Effect {
    let followed = draw.between(20_000.0, 30_000.0);
    in_one("multiplexer that slews from the previous channel", draw, move |campaign, run, sensor, size| {
        let field = |sensor: usize, t: f64| run.along(&campaign.bench, sensor, t);
        let difference = |t: f64| field((sensor + 2) % 3, t) - field(sensor, t);
        run.times.iter().map(|t| size * unsettled(difference(*t), followed)).collect()
    })
}

/// A field with a relative error for each row, over [`FULL_NT`].
fn gained(campaign: &Campaign, run: &Run, sensor: usize, gain: impl Fn(f64) -> f64) -> Vec<f64> {
    run.times.iter().map(|t| gain(*t) * run.along(&campaign.bench, sensor, *t) / FULL_NT).collect()
}

/// Ripple of the converter's reference at half the mains frequency: an alias whose phase wanders, in the gain
/// alone.
///
/// ```text
/// dB = s B / 50 000 nT · sin(2π t / P + w(t))
/// ```
///
/// dB and s in nT, P between 3 and 8 readings, w of 2 rad rms over some tens of readings.
///
/// Source: Kester (ed.) 2005, Data Conversion Handbook (voltage references).
pub fn ripple(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let step = campaign.runs[0].step_s();
    let period = step * draw.between(3.0, 8.0);
    let phase = wandering(draw, 2.0, [30.0 * step, 120.0 * step], 3);
    in_one("ripple of the converter's reference", draw, move |campaign, run, sensor, size| {
        gained(campaign, run, sensor, |t| size * (TAU * t / period + phase(t)).sin())
    })
}

/// A triangle between 0 and 1: up for a share of its period, down for the rest.
fn triangle(turns: f64, up: f64) -> f64 {
    let x = turns.rem_euclid(1.0);
    if x < up { x / up } else { (1.0 - x) / (1.0 - up) }
}

/// A reference in an oven whose thermostat goes on and off: the gain goes up and down between two levels.
///
/// ```text
/// dB = s B / 50 000 nT · (triangle(t / P) − 1/2)
/// ```
///
/// dB and s in nT, P between 12 and 30 readings, of which the triangle rises for 20 to 40 %.
pub fn oven(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let period = campaign.runs[0].step_s() * draw.between(12.0, 30.0);
    let (up, begin) = (draw.between(0.2, 0.4), draw.between(0.0, 1.0));
    in_one("thermostat of the reference's oven", draw, move |campaign, run, sensor, size| {
        gained(campaign, run, sensor, |t| size * (triangle(t / period + begin, up) - 0.5))
    })
}

/// ±1, the other one after each passage of a level from below.
fn toggled(course: &[f64], level: f64) -> Vec<f64> {
    let mut state = 1.0;
    let mut before = f64::INFINITY;
    let next = |value: &f64| {
        if before < level && *value >= level {
            state = -state;
        }
        before = *value;
        state
    };
    course.iter().map(next).collect()
}

/// A latching relay that goes over each time the field passes a level upwards: its two resistors are not
/// quite equal.
///
/// ```text
/// dB = s B / 50 000 nT · (−1)^n, n the passages through B_t from below
/// ```
///
/// dB and s in nT, B_t a fifth of the largest field.
pub fn relay(_: &Campaign, draw: &mut Draw) -> Effect {
    in_one("relay that goes over at each passage of a level", draw, |campaign, run, sensor, size| {
        let field: Vec<f64> = run.times.iter().map(|t| run.along(&campaign.bench, sensor, *t)).collect();
        let states = toggled(&field, TOGGLES_AT * largest(campaign, sensor));
        field.iter().zip(states).map(|(field, state)| size * state * field / FULL_NT).collect()
    })
}

/// A supply that sags under a load: the sensitivity follows a current that is recorded, while its field is
/// none.
///
/// ```text
/// dB = s B / 50 000 nT · (I − I_mean) / 1 A
/// ```
///
/// dB and s in nT.
pub fn load(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let current = |run: &Run, t: f64| run.column("panel_current_a").map_or(0.0, |current| current(t));
    let mean = mean(campaign, current);
    in_one("sensitivity with the current of a load", draw, move |campaign, run, sensor, size| {
        gained(campaign, run, sensor, |t| size * (current(run, t) - mean))
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{campaign, of_sensor};
    use super::*;

    /// Contributions of a size of one with the fields they belong to.
    fn with_fields(campaign: &Campaign, effect: &Effect) -> Vec<(f64, f64)> {
        let field =
            |run: &Run| run.times.iter().map(|t| run.along(&campaign.bench, effect.sensors[0], *t)).collect();
        let fields: Vec<Vec<f64>> = campaign.runs.iter().map(field).collect();
        of_sensor(campaign, effect).into_iter().flatten().zip(fields.into_iter().flatten()).collect()
    }

    /// Under a constant load the beat is a sine of a constant period.
    #[test]
    fn a_constant_load_beats_steadily() {
        let times: Vec<f64> = (0..90).map(|k| 5.0 + 2.0 * f64::from(k)).collect();
        for (t, phase) in times.iter().zip(beating(&times, |_| 0.6, 14.0, 1.5)) {
            assert!((phase - TAU * 1.9 * (t - 5.0) / 14.0).abs() < 1e-9);
        }
    }

    /// Below its threshold a loop is quiet, above it the amplitude is √(excess).
    #[test]
    fn a_loop_rings_in_large_fields_alone() {
        let campaign = campaign(1);
        let effect = ringing(&campaign, &mut Draw::new("ringing", 1));
        let from = RINGS_FROM * largest(&campaign, effect.sensors[0]);
        let all = with_fields(&campaign, &effect);
        assert!(all.iter().any(|(value, _)| value.abs() > 0.1));
        for (value, field) in all {
            let most = (field.abs() / from - 1.0).max(0.0).sqrt();
            assert!(value.abs() <= most + 1e-12, "{value} for {most}");
        }
    }

    /// Small differences are followed, and the two directions are alike.
    #[test]
    fn a_multiplexer_misses_large_differences_alone() {
        assert_eq!(unsettled(0.9, 1.0), 0.0);
        assert!((unsettled(1.5, 1.0) - 0.5).abs() < 1e-12);
        for k in 0..40 {
            let difference = 0.1 * f64::from(k);
            assert_eq!(unsettled(difference, 2.0), -unsettled(-difference, 2.0));
        }
    }

    /// The gain of a ripple is a sine: its square has a mean of 1/2.
    #[test]
    fn a_ripple_is_a_sine_in_the_gain() {
        let campaign = campaign(2);
        let all = with_fields(&campaign, &ripple(&campaign, &mut Draw::new("ripple", 1)));
        let squares = all.iter().map(|(value, field)| (FULL_NT * value / field).powi(2));
        let mean = squares.sum::<f64>() / all.len() as f64;
        assert!((mean - 0.5).abs() < 0.03, "{mean}");
    }

    /// A triangle is spread evenly between 0 and 1, whatever its shape: mean 1/2 and variance 1/12.
    #[test]
    fn a_triangle_has_the_moments_of_an_even_spread() {
        for up in [0.2, 0.3, 0.5] {
            let all: Vec<f64> = (0..10_000).map(|k| triangle(f64::from(k) / 10_000.0, up) - 0.5).collect();
            let mean = |power: i32| all.iter().map(|x| x.powi(power)).sum::<f64>() / all.len() as f64;
            assert!(mean(1).abs() < 1e-3 && (mean(2) - 1.0 / 12.0).abs() < 1e-3);
        }
    }

    /// A sine toggles once in its period, so that after two the relay is where it was.
    #[test]
    fn a_relay_toggles_once_in_a_period() {
        let course: Vec<f64> = (0..400).map(|k| (TAU * (f64::from(k) - 0.5) / 100.0).sin()).collect();
        let states = toggled(&course, 0.3);
        assert_eq!(states.windows(2).filter(|pair| pair[0] != pair[1]).count(), 4);
        assert_eq!(states.iter().sum::<f64>(), -200.0 + 2.0 * 100.0);
    }

    /// The gain is what the current is beside its mean, whose mean is zero.
    #[test]
    fn a_load_leaves_the_mean_gain() {
        let campaign = campaign(3);
        let all = with_fields(&campaign, &load(&campaign, &mut Draw::new("load", 1)));
        let gain = all.iter().map(|(value, field)| FULL_NT * value / field);
        assert!((gain.sum::<f64>() / all.len() as f64).abs() < 1e-9);
    }
}
