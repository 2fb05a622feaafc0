//! What follows a temperature late, by several laws.

use std::sync::Arc;

use super::electronics::span;
use crate::draw::Draw;
use crate::effect::{Effect, named, on_sensor};
use crate::finer::{beside, bodies, convection, modes, thermal, wall};
use crate::scene::{Campaign, Run};
use crate::signal::Signal;

/// Temperatures over the reference at the rows of a run, K.
type Course = Arc<dyn Fn(&Campaign, &Run) -> Vec<f64> + Send + Sync>;

/// A temperature behind a thermometer.
pub struct Behind {
    /// Its course.
    pub course: Course,
    /// By what a slow course comes out late, s, where that is one number.
    pub lag_s: Option<f64>,
    physics: &'static str,
}

/// A law: of the campaign and the number of its thermometer.
pub type Law = fn(&Campaign, &mut Draw, usize) -> Behind;

fn behind(
    physics: &'static str,
    lag_s: Option<f64>,
    thermometer: usize,
    of: impl Fn(&Signal, &[f64]) -> Vec<f64> + Send + Sync + 'static,
) -> Behind {
    let course = Arc::new(move |campaign: &Campaign, run: &Run| {
        let warm = of(&run.temperatures[thermometer], &run.times);
        warm.into_iter().map(|t| t - campaign.reference_c[thermometer]).collect()
    });
    Behind { course, lag_s, physics }
}

/// Some hundredths of the campaign, s.
fn late(campaign: &Campaign, draw: &mut Draw) -> f64 {
    span(campaign) * draw.octaves(0.02, 0.06)
}

/// One body in still air: its time constant falls with the difference of temperatures.
pub fn one_body(campaign: &Campaign, draw: &mut Draw, thermometer: usize) -> Behind {
    let tau = late(campaign, draw);
    behind("a body that still air warms", None, thermometer, move |signal, times| {
        convection::body(signal, times, tau)
    })
}

/// Two bodies between which the heat flows both ways.
pub fn two_bodies(campaign: &Campaign, draw: &mut Draw, thermometer: usize) -> Behind {
    let (total, back) = (late(campaign, draw), 0.2);
    let [board, part] = [0.7 * total, 0.3 * total / (1.0 + back)];
    behind("two bodies that warm each other", Some(total), thermometer, move |signal, times| {
        thermal::core(signal, times, board, part, back)
    })
}

/// Three bodies in a row.
pub fn three_bodies(campaign: &Campaign, draw: &mut Draw, thermometer: usize) -> Behind {
    let total = late(campaign, draw);
    behind("three bodies in a row", Some(total), thermometer, move |signal, times| {
        bodies::last(signal, times, [0.5 * total, 0.3 * total, 0.2 * total], 0.0)
    })
}

/// A wall through which the heat diffuses.
pub fn diffusion(campaign: &Campaign, draw: &mut Draw, thermometer: usize) -> Behind {
    let tau = late(campaign, draw);
    let lag = wall::mean_lag(tau);
    behind("heat that diffuses through a wall", Some(lag), thermometer, move |signal, times| {
        wall::inner_face(signal, times, tau)
    })
}

/// A thermometer elsewhere that is late itself, by a fifth to two fifths of what the core is.
pub fn thermometer_elsewhere(campaign: &Campaign, draw: &mut Draw, thermometer: usize) -> Behind {
    let (core, share) = (late(campaign, draw), draw.between(0.2, 0.4));
    behind("a core beside a thermometer that is late itself", None, thermometer, move |signal, times| {
        bodies::beside_a_late_thermometer(signal, times, share * core, core)
    })
}

/// A body of many modes.
fn of_modes<const N: usize>(
    physics: &'static str,
    lags: [(f64, f64); N],
    lag_s: Option<f64>,
    thermometer: usize,
) -> Behind {
    behind(physics, lag_s, thermometer, move |signal, times| beside::lags(signal, times, lags, 0.0))
}

/// A round rod into which the heat diffuses.
pub fn rod(campaign: &Campaign, draw: &mut Draw, thermometer: usize) -> Behind {
    let lags = modes::seconds(modes::rod(), 1.3 * late(campaign, draw));
    of_modes("a round rod into which the heat diffuses", lags, Some(modes::mean_lag(&lags)), thermometer)
}

/// A potted sphere into which the heat diffuses.
pub fn sphere(campaign: &Campaign, draw: &mut Draw, thermometer: usize) -> Behind {
    let lags = modes::seconds(modes::sphere(), 1.4 * late(campaign, draw));
    of_modes("a potted sphere into which the heat diffuses", lags, Some(modes::mean_lag(&lags)), thermometer)
}

/// Foam and boards without one time constant.
pub fn spread(campaign: &Campaign, draw: &mut Draw, thermometer: usize) -> Behind {
    let lags = modes::seconds(modes::spread::<9>(0.8, 2.5), late(campaign, draw));
    of_modes("parts with a spread of time constants", lags, None, thermometer)
}

fn with_lag(mut parameters: Vec<(&'static str, f64)>, lag_s: Option<f64>) -> Vec<(&'static str, f64)> {
    parameters.extend(lag_s.map(|lag| ("lag_s", lag)));
    parameters
}

/// An offset in proportion to a temperature behind the thermometer 0 of the sensor or 1 of the electronics.
pub fn offset(campaign: &Campaign, draw: &mut Draw, thermometer: usize, law: Law) -> Effect {
    let (sensor, coefficient) = (draw.below(3), 0.1 * draw.sign());
    let Behind { course, lag_s, physics } = law(campaign, draw, thermometer);
    let act = on_sensor(sensor, move |campaign, run, _, size| {
        course(campaign, run).iter().map(|warm| size * coefficient * warm).collect()
    });
    let name = ["offset_temperature_lag", "offset_electronics_temperature_lag"][thermometer];
    Effect::new(physics, vec![named(name, sensor)], act)
        .in_sensor(sensor)
        .with(move |size| with_lag(vec![("coefficient_nt_per_k", size * coefficient)], lag_s))
}

/// A sensitivity in proportion to a temperature behind a thermometer.
pub fn sensitivity(campaign: &Campaign, draw: &mut Draw, thermometer: usize, law: Law) -> Effect {
    let (sensor, ppm) = (draw.below(3), 20.0 * draw.sign());
    let Behind { course, lag_s, physics } = law(campaign, draw, thermometer);
    let act = on_sensor(sensor, move |campaign, run, plain, size| {
        let warm = course(campaign, run);
        warm.iter().zip(plain).map(|(warm, reading)| 1e-6 * size * ppm * warm * reading).collect()
    });
    let name = ["sensitivity_temperature_lag", "sensitivity_electronics_temperature_lag"][thermometer];
    Effect::new(physics, vec![named(name, sensor)], act)
        .in_sensor(sensor)
        .with(move |size| with_lag(vec![("coefficient_ppm_per_k", size * ppm)], lag_s))
}
