//! In the sensor itself.

use nalgebra::Vector3;

use super::loops::{PAST, followed};
use crate::draw::Draw;
use crate::effect::{Effect, named, on_sensor};
use crate::finer::preisach::Preisach;
use crate::finer::thermal;
use crate::scene::{Campaign, Run};

pub(super) const ARCSEC: f64 = 4.848e-6;
/// Field to which coefficients of nonlinearity belong, nT.
pub(super) const FULL_NT: f64 = 50_000.0;

/// Fields across a sensor in cyclic order, SEN, over [`FULL_NT`].
pub(super) fn across(campaign: &Campaign, run: &Run, sensor: usize, t: f64) -> [f64; 2] {
    let field: Vector3<f64> = run.field_sen(&campaign.bench, t) / FULL_NT;
    [field[(sensor + 1) % 3], field[(sensor + 2) % 3]]
}

fn warmer(run: &Run, campaign: &Campaign, t: f64) -> f64 {
    run.temperatures[0](t) - campaign.reference_c[0]
}

/// A core of domains with a distribution of coercive fields (Preisach), whose past is the drive before the
/// recording.
pub fn hysteresis(_: &Campaign, draw: &mut Draw) -> Effect {
    let sensor = draw.below(3);
    let (coercive, spread) = (draw.octaves(700.0, 4000.0), draw.between(0.2, 0.5));
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let mut core = Preisach::new(coercive, spread, 60_000.0);
        let lag = followed(campaign, run, sensor, PAST, |field| core.lag(field));
        lag.into_iter().map(|lag| 20.0 * size * lag).collect()
    });
    Effect::new("Preisach's model, coercive fields log-normal", vec![named("hysteresis", sensor)], act)
        .in_sensor(sensor)
}

/// An offset that grows exponentially with temperature.
pub fn offset_temperature(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, coefficient, scale_k) = (draw.below(3), 0.1 * draw.sign(), draw.between(35.0, 90.0));
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let law = |t: &f64| scale_k * ((warmer(run, campaign, *t) / scale_k).exp() - 1.0);
        run.times.iter().map(|t| size * coefficient * law(t)).collect()
    });
    Effect::new("offset exponential in temperature", vec![named("offset_temperature", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| vec![("coefficient_nt_per_k", size * coefficient)])
}

/// Time constants of former and core for a recording's span.
fn bodies(campaign: &Campaign, draw: &mut Draw) -> [f64; 2] {
    let span: f64 = campaign.runs.iter().map(|run| run.step_s() * run.times.len() as f64).sum();
    let former = span * draw.octaves(0.015, 0.05);
    [former, former * draw.between(0.15, 0.4)]
}

/// Share of the heat that flows back.
const BACK: f64 = 0.2;

fn core_temperature(run: &Run, campaign: &Campaign, [former, core]: [f64; 2]) -> Vec<f64> {
    let warm = thermal::core(&run.temperatures[0], &run.times, former, core, BACK);
    warm.into_iter().map(|t| t - campaign.reference_c[0]).collect()
}

/// What a slow course lags by, s.
fn mean_lag([former, core]: [f64; 2]) -> f64 {
    former + core * (1.0 + BACK)
}

/// The core behind its former behind the thermometer.
pub fn offset_temperature_lag(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, coefficient, bodies) = (draw.below(3), 0.1 * draw.sign(), bodies(campaign, draw));
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        core_temperature(run, campaign, bodies).iter().map(|t| size * coefficient * t).collect()
    });
    Effect::new("offset behind two thermal bodies", vec![named("offset_temperature_lag", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| vec![("coefficient_nt_per_k", size * coefficient), ("lag_s", mean_lag(bodies))])
}

/// A feedback coil whose radius grows: the field of a current goes with one over it.
pub fn sensitivity_temperature(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, ppm) = (draw.below(3), 20.0 * draw.sign());
    let act = on_sensor(sensor, move |campaign, run, plain, size| {
        let grown = |t: f64| {
            let warm = warmer(run, campaign, t);
            1.0 / (1.0 - 1e-6 * size * ppm * (warm + 0.004 * warm * warm)) - 1.0
        };
        run.times.iter().zip(plain).map(|(t, reading)| reading * grown(*t)).collect()
    });
    Effect::new("feedback coil that expands", vec![named("sensitivity_temperature", sensor)], act)
        .in_sensor(sensor)
        .with(move |size| vec![("coefficient_ppm_per_k", size * ppm)])
}

/// The same, behind two thermal bodies.
pub fn sensitivity_temperature_lag(campaign: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, ppm, bodies) = (draw.below(3), 20.0 * draw.sign(), bodies(campaign, draw));
    let act = on_sensor(sensor, move |campaign, run, plain, size| {
        let warm = core_temperature(run, campaign, bodies);
        warm.iter().zip(plain).map(|(t, reading)| 1e-6 * size * ppm * t * reading).collect()
    });
    let accepted = vec![named("sensitivity_temperature_lag", sensor)];
    Effect::new("feedback coil behind two thermal bodies", accepted, act)
        .in_sensor(sensor)
        .with(move |size| vec![("coefficient_ppm_per_k", size * ppm), ("lag_s", mean_lag(bodies))])
}

/// A block that bends as it warms, a little late.
pub fn axis_temperature(_: &Campaign, draw: &mut Draw) -> Effect {
    let sensor = draw.below(3);
    let turns = [draw.sign() * draw.between(0.4, 1.0), draw.sign() * draw.between(0.4, 1.0)];
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        let step = run.step_s();
        let warm = core_temperature(run, campaign, [step, 0.4 * step]);
        let turned = |(t, warm): (&f64, &f64)| {
            let [u, v] = across(campaign, run, sensor, *t);
            ARCSEC * size * warm * FULL_NT * (turns[0] * u + turns[1] * v)
        };
        run.times.iter().zip(&warm).map(turned).collect()
    });
    let accepted = vec![named("axis_temperature", sensor), named("axis_creep", sensor)];
    Effect::new("block that bends, a sample late", accepted, act).in_sensor(sensor).with(move |size| {
        vec![("first_arcsec_per_k", size * turns[0]), ("second_arcsec_per_k", size * turns[1])]
    })
}

/// A formula of the own field and those across, over [`FULL_NT`].
pub(super) fn of_fields(
    sensor: usize,
    formula: impl Fn(f64, f64, f64) -> f64 + Send + Sync + 'static,
) -> crate::effect::Act {
    on_sensor(sensor, move |campaign, run, _, size| {
        let value = |t: &f64| {
            let own = run.along(&campaign.bench, sensor, *t) / FULL_NT;
            let [u, v] = across(campaign, run, sensor, *t);
            size * formula(own, u, v)
        };
        run.times.iter().map(value).collect()
    })
}

/// A loop whose gain differs for the two signs: even, and not quite a parabola.
pub fn quadratic(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, size) = (draw.below(3), draw.sign());
    let act = of_fields(sensor, move |x, _, _| size * 2.0 * ((1.0 + x * x).sqrt() - 1.0));
    Effect::new("gain unlike for the two signs", vec![named("quadratic_nonlinearity", sensor)], act)
        .in_sensor(sensor)
}

/// A loop whose gain falls as the core's permeability does.
pub fn cubic(_: &Campaign, draw: &mut Draw) -> Effect {
    let (sensor, size) = (draw.below(3), draw.sign());
    let act = of_fields(sensor, move |x, _, _| size * (x.sinh() - x));
    Effect::new("permeability that falls with the field", vec![named("cubic_nonlinearity", sensor)], act)
        .in_sensor(sensor)
}

/// Parts of the core that a field across saturates.
pub fn cross_field(_: &Campaign, draw: &mut Draw) -> Effect {
    let sensor = draw.below(3);
    let [a, b, c] = [4.0 * draw.sign(), draw.between(-3.0, 3.0), draw.between(-2.0, 2.0)];
    let act = of_fields(sensor, move |_, u, v| {
        (a * u * u + b * v * v + c * u * v) / (1.0 + 0.15 * (u * u + v * v))
    });
    Effect::new("core that a field across saturates", vec![named("cross_field", sensor)], act)
        .in_sensor(sensor)
}

/// Permeability that falls with a field across.
pub fn cross_field_sensitivity(_: &Campaign, draw: &mut Draw) -> Effect {
    let sensor = draw.below(3);
    let [a, b] = [4.0 * draw.sign(), draw.between(-4.0, 4.0)];
    let act = of_fields(sensor, move |own, u, v| own * (a * u + b * v) / (1.0 + 0.15 * (u * u + v * v)));
    let accepted = vec![named("cross_field_sensitivity", sensor)];
    Effect::new("sensitivity that a field across changes", accepted, act).in_sensor(sensor)
}
