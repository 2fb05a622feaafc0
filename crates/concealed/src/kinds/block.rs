//! The block that holds a sensor, and the core's balance.

use std::sync::Arc;

use super::electronics::span;
use super::sensor::{ARCSEC, FULL_NT, across};
use crate::draw::Draw;
use crate::effect::{Effect, named, on_sensor};
use crate::finer::beside;
use crate::scene::Campaign;
use crate::signal::Signal;

/// A glue that creeps after a change of temperature, with three relaxation times about one of them.
pub fn creeping_glue(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let sensor = draw.below(3);
    let turns = [draw.sign() * draw.between(0.4, 1.0), draw.sign() * draw.between(0.4, 1.0)];
    let tau = span(campaign) * draw.octaves(0.02, 0.06);
    let elements = [(0.2, 0.4 * tau), (0.6, tau), (0.2, 2.5 * tau)];
    let lag: f64 = elements.iter().map(|(weight, tau)| weight * tau).sum();
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let reference_c = campaign.reference_c[0];
        let thermometer = run.temperatures[0].clone();
        let warm: Signal = Arc::new(move |t| thermometer(t) - reference_c);
        let crept = beside::lags(&warm, &run.times, elements, 0.0);
        let turned = |(t, crept): (&f64, &f64)| {
            let [u, v] = across(campaign, run, sensor, *t);
            ARCSEC * size * crept * FULL_NT * (turns[0] * u + turns[1] * v)
        };
        run.times.iter().zip(&crept).map(turned).collect()
    });
    Effect::new("glue that creeps with three relaxation times", vec![named("axis_creep", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| {
            let [first, second] = turns.map(|turn| size * turn);
            vec![("first_arcsec_per_k", first), ("second_arcsec_per_k", second), ("lag_s", lag)]
        })
}

/// A compensation that works on one side of a temperature: a hyperbola with two straight arms.
pub fn hyperbola(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, half, width) = (draw.below(3), 0.1 * draw.sign(), draw.between(0.4, 1.2));
    let coefficient = half * draw.between(-0.4, 0.4);
    let inflection_c = campaign.reference_c[0] + draw.between(-2.0, 2.0);
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let reference_c = campaign.reference_c[0];
        let arms = |t: f64| (t - inflection_c).hypot(width);
        let law = |t: f64| coefficient * (t - reference_c) + half * (arms(t) - arms(reference_c));
        run.times.iter().map(|t| size * law(run.temperatures[0](*t))).collect()
    });
    let accepted = vec![named("offset_temperature_inflection", sensor)];
    Effect::new("compensation that works on one side of a temperature", accepted, act).in_sensor(sensor).with(
        move |size| {
            vec![
                ("coefficient_nt_per_k", size * coefficient),
                ("half_change_nt_per_k", size * half),
                ("inflection_k", inflection_c + 273.15),
            ]
        },
    )
}
