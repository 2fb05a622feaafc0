//! What follows a temperature at once, by further laws.

use std::sync::Arc;

use super::electronics::span;
use super::sensor::{ARCSEC, FULL_NT, across};
use crate::draw::Draw;
use crate::effect::{Effect, named, on_sensor};
use crate::finer::plays::Plays;
use crate::finer::thermistor::Thermistor;
use crate::finer::{beside, modes};
use crate::scene::Campaign;
use crate::signal::Signal;

/// What a magnetisation that falls with T^(3/2) has fallen by between two temperatures, degC, over its slope
/// at the first: in K. Source: Bloch 1930, Zur Theorie des Ferromagnetismus, Z. Phys. 61, 206.
fn fallen(from_c: f64, to_c: f64) -> f64 {
    let (from, to) = (from_c + 273.15, to_c + 273.15);
    (to.powf(1.5) - from.powf(1.5)) / (1.5 * from.sqrt())
}

/// A magnetised screw whose moment falls as Bloch has it.
pub fn remanence(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, coefficient) = (draw.below(3), 0.1 * draw.sign());
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let law = |t: &f64| fallen(campaign.reference_c[0], run.temperatures[0](*t));
        run.times.iter().map(|t| size * coefficient * law(t)).collect()
    });
    Effect::new("remanence that falls with the power 3/2", vec![named("offset_temperature", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| vec![("coefficient_nt_per_k", size * coefficient)])
}

/// Copper's resistance, per K at 20 degC.
const COPPER_PER_K: f64 = 0.00393;

/// What a loop of a gain G reads of a field, less what it reads at the reference, relative: G falls as the
/// copper of the pick-up warms,
///
/// ```text
/// G = G_0 / (1 + α ΔT),   M / M_0 − 1 = (1 + 1/G_0) / (1 + 1/G) − 1
/// ```
fn loop_error(gain: f64, warm_k: f64) -> f64 {
    let inverse = (1.0 + COPPER_PER_K * warm_k) / gain;
    (1.0 + 1.0 / gain) / (1.0 + inverse) - 1.0
}

/// A feedback loop whose gain is finite, and falls as its copper warms.
pub fn finite_gain(_: &Campaign, draw: &mut Draw) -> Effect {
    let sensor = draw.below(3);
    // 20 ppm/K for a size of 1.
    let gain = move |size: f64| COPPER_PER_K / (20e-6 * size);
    let act = on_sensor(sensor, move |campaign, run, plain, size| {
        let warm = |t: &f64| run.temperatures[0](*t) - campaign.reference_c[0];
        run.times.iter().zip(plain).map(|(t, m)| m * loop_error(gain(size), warm(t))).collect()
    });
    Effect::new("loop of finite gain with warm copper", vec![named("sensitivity_temperature", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| vec![("coefficient_ppm_per_k", -1e6 * COPPER_PER_K / (1.0 + gain(size)))])
}

/// An offset in proportion to the electronics' temperature, whose thermometer is a thermistor read along a
/// straight line.
pub fn thermistor(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, coefficient) = (draw.below(3), 0.1 * draw.sign());
    let thermistor = Thermistor {
        beta_k: draw.between(3300.0, 4200.0),
        ratio: draw.octaves(0.5, 4.0),
        tangent_c: campaign.reference_c[1],
    };
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let warm = |t: &f64| thermistor.temperature(run.temperatures[1](*t)) - campaign.reference_c[1];
        run.times.iter().map(|t| size * coefficient * warm(t)).collect()
    });
    let accepted = vec![named("offset_electronics_temperature", sensor)];
    Effect::new("thermistor that is read along a straight line", accepted, act)
        .in_sensor(sensor)
        .with(move |size| vec![("coefficient_nt_per_k", size * coefficient)])
}

/// The integral of the arctangent: u atan u − ln(1 + u²) / 2.
fn area(u: f64) -> f64 {
    u * u.atan() - 0.5 * (u * u).ln_1p()
}

/// Two unlike bars that share their stress about a temperature: a coefficient that goes over as an
/// arctangent.
pub fn two_bars(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, half, width) = (draw.below(3), 0.1 * draw.sign(), draw.between(0.3, 0.8));
    let coefficient = half * draw.between(-0.4, 0.4);
    let inflection_c = campaign.reference_c[0] + draw.between(-2.0, 2.0);
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let reference_c = campaign.reference_c[0];
        let arms = |t: f64| std::f64::consts::FRAC_2_PI * width * area((t - inflection_c) / width);
        let law = |t: f64| coefficient * (t - reference_c) + half * (arms(t) - arms(reference_c));
        run.times.iter().map(|t| size * law(run.temperatures[0](*t))).collect()
    });
    let accepted = vec![named("offset_temperature_inflection", sensor)];
    Effect::new("two bars that share their stress", accepted, act).in_sensor(sensor).with(move |size| {
        vec![
            ("coefficient_nt_per_k", size * coefficient),
            ("half_change_nt_per_k", size * half),
            ("inflection_k", inflection_c + 273.15),
        ]
    })
}

/// Angles per K about the two directions across a sensor, seconds of arc.
fn turns(draw: &mut Draw) -> [f64; 2] {
    [draw.sign() * draw.between(0.4, 1.0), draw.sign() * draw.between(0.4, 1.0)]
}

/// A mount with some play: the axis follows the temperature after it has turned by a few tenths of a kelvin.
pub fn backlash(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, turns, play_k) = (draw.below(3), turns(draw), draw.between(0.15, 0.4));
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let mut mount = Plays::new([(play_k, 1.0)]);
        let turned = |t: &f64| {
            let warm = mount.go(run.temperatures[0](*t) - campaign.reference_c[0]);
            let [u, v] = across(campaign, run, sensor, *t);
            ARCSEC * size * warm * FULL_NT * (turns[0] * u + turns[1] * v)
        };
        run.times.iter().map(turned).collect()
    });
    let accepted = vec![named("axis_temperature", sensor), named("axis_creep", sensor)];
    Effect::new("mount with some play", accepted, act).in_sensor(sensor).with(move |size| {
        vec![("first_arcsec_per_k", size * turns[0]), ("second_arcsec_per_k", size * turns[1])]
    })
}

/// A filled resin that creeps after a change of temperature, with a spread of relaxation times.
pub fn resin(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, turns) = (draw.below(3), turns(draw));
    let middle = span(campaign) * draw.octaves(0.02, 0.05);
    let lags = modes::seconds(modes::spread::<9>(0.75, 3.0), middle);
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let (thermometer, reference_c) = (run.temperatures[0].clone(), campaign.reference_c[0]);
        let warm: Signal = Arc::new(move |t| thermometer(t) - reference_c);
        let crept = beside::lags(&warm, &run.times, lags, 0.0);
        let turned = |(t, crept): (&f64, &f64)| {
            let [u, v] = across(campaign, run, sensor, *t);
            ARCSEC * size * crept * FULL_NT * (turns[0] * u + turns[1] * v)
        };
        run.times.iter().zip(&crept).map(turned).collect()
    });
    Effect::new("resin with a spread of relaxation times", vec![named("axis_creep", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| {
            vec![("first_arcsec_per_k", size * turns[0]), ("second_arcsec_per_k", size * turns[1])]
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slope 1 at the first temperature, and a second derivative of 1/2T.
    #[test]
    fn a_magnetisation_falls_with_its_slope() {
        let of = |dt: f64| fallen(20.0, 20.0 + dt);
        assert!(((of(0.01) - of(-0.01)) / 0.02 - 1.0).abs() < 1e-6);
        assert!(((of(1.0) + of(-1.0)) * 2.0 * 293.15 - 1.0).abs() < 1e-3);
    }

    /// −α / (1 + G) per K.
    #[test]
    fn a_loop_of_finite_gain_has_its_slope() {
        for gain in [50.0, 400.0] {
            let slope = (loop_error(gain, 0.01) - loop_error(gain, -0.01)) / 0.02;
            assert!((slope * (1.0 + gain) / COPPER_PER_K + 1.0).abs() < 1e-6);
            assert!(loop_error(gain, 0.0).abs() < 1e-15);
        }
    }

    #[test]
    fn the_area_is_the_integral_of_the_arctangent() {
        for u in [-3.0, -0.2, 0.7, 9.0] {
            assert!(((area(u + 1e-4) - area(u - 1e-4)) / 2e-4 - f64::atan(u)).abs() < 1e-7);
        }
        assert_eq!(area(0.0), 0.0);
    }
}
