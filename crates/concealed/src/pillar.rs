//! A month of an observatory: a variometer beside the reference, with three things that nobody declared.

use nalgebra::{Matrix3, Vector3};
use serde_json::{Map, Value, json};
use std::sync::Arc;

use crate::case::{Case, TrueEffect, Truth, nonce};
use crate::document::rounded;
use crate::draw::Draw;
use crate::noise::Noise;
use crate::scene::AXES;
use crate::sets::neutral;
use crate::signal::{Signal, mixed, over, sines, wandering};
use crate::swarm::rms;

const STEP_S: f64 = 60.0;
const DAYS: usize = 30;

/// The month of a seed.
///
/// The variometer's y has a temperature coefficient that changes sign at an inflection,
///
/// ```text
/// dB_y = c (√((T − T_1)² + w²) − w)
/// ```
///
/// its clock is some seconds late, and its z steps once. Sizes as Jankowski and Sucksdorff 1996 (IAGA Guide
/// for Magnetic Measurements and Observatory Practice) have them for paired variometers: 1.5 to 3 nT apart
/// over a day.
pub fn month(seed: u64) -> Case {
    let mut draw = Draw::new("pillar", seed);
    let count = DAYS * 1440;
    let times: Vec<f64> = (0..count).map(|row| row as f64 * STEP_S).collect();
    let field = [21_000.0, 900.0, 43_000.0].map(|level| over(level, natural(&mut draw)));
    let temperature = room(&mut draw);
    let eta = Matrix3::new(0.9994, 0.0131, -0.0062, -0.0127, 1.0008, 0.0044, 0.0071, -0.0039, 0.9997);
    let offset: Vector3<f64> = Vector3::from_fn(|_, _| draw.between(-40.0, 40.0));
    let (slope, inflection, width) = (draw.between(0.35, 0.6), draw.between(17.0, 19.0), 3.0);
    let late = draw.sign() * draw.between(3.0, 7.0);
    let (height, at) = (draw.sign() * draw.between(0.6, 1.0), draw.between(0.4, 0.7) * times[count - 1]);
    let noise = Noise { white_nt: 0.04, flicker_nt2_per_hz: 2e-4, exponent: 1.0, old: false };
    let warmed = |t: f64| slope * (((temperature(t) - inflection).powi(2) + width * width).sqrt() - width);

    let mut columns = Map::new();
    columns.insert("time_s".into(), rounded(times.iter().copied(), 1.0));
    for (axis, field) in AXES.iter().zip(&field) {
        columns.insert(format!("reference_{axis}_nt"), rounded(times.iter().map(|t| field(*t)), 1e-2));
    }
    let mut squares = 0.0;
    for (sensor, axis) in AXES.iter().enumerate() {
        let own = flicker_by_pieces(&noise, count, &mut draw);
        squares += own.iter().map(|v| v * v).sum::<f64>();
        let read = times.iter().zip(&own).map(|(&t, own)| {
            let felt: f64 = (0..3).map(|k| field[k](t - late) * eta[(k, sensor)]).sum();
            let undeclared = match sensor {
                1 => warmed(t),
                2 if t >= at => height,
                _ => 0.0,
            };
            felt + offset[sensor] + undeclared + own
        });
        columns.insert(format!("test_{axis}_nt"), rounded(read, 1e-2));
    }
    columns.insert("sensor_temperature_c".into(), rounded(times.iter().map(|t| temperature(*t)), 1e-2));
    let case = neutral(&format!("pillar/{seed}"));
    let document = json!({
        "fluxcal": 1,
        "title": case,
        "instrument": {"range_nt": 80000, "quantisation_nt": 0.01, "noise": {"white_rms_nt": noise.white_nt,
            "flicker_nt2_per_hz_at_1hz": noise.flicker_nt2_per_hz, "flicker_exponent": noise.exponent}},
        "recordings": [{"id": "month", "procedure": "differential", "start": "2026-03-01T00:00:00+00:00", "columns": columns}],
    });
    let about_mean = |of: &dyn Fn(f64) -> f64| {
        let mean = times.iter().map(|t| of(*t)).sum::<f64>() / count as f64;
        rms(times.iter().map(|t| of(*t) - mean))
    };
    let sizes = [
        about_mean(&warmed),
        about_mean(&|t| field[0](t - late) - field[0](t)),
        about_mean(&|t| if t >= at { height } else { 0.0 }),
    ];
    let noise_nt = (squares / (3 * count) as f64).sqrt();
    let effect =
        |which: usize, physics: &str, accepted: &str, sensors: &[&str], parameters: Value| TrueEffect {
            name: ["temperature with an inflection", "clock offset", "step"][which].into(),
            physics: physics.into(),
            accepted: vec![accepted.into()],
            sensors: sensors.iter().map(|axis| (*axis).to_string()).collect(),
            parameters: parameters.as_object().cloned().unwrap_or_default(),
            form_error: 0.0,
            left_nt: sizes[which],
        };
    let effects = vec![
        effect(
            0,
            "offset whose slope changes sign at a temperature",
            "offset_temperature_inflection y",
            &["y"],
            json!({"slope_nt_per_k": slope, "inflection_c": inflection}),
        ),
        effect(1, "the field taken at another moment", "clock_offset", &[], json!({"offset_s": late})),
        effect(2, "one step", "reading_step z", &["z"], json!({"height_nt": height, "time_s": at})),
    ];
    let truth = Truth {
        case,
        set: "pillar".into(),
        seed,
        number: 0,
        strength: sizes[0] / noise_nt,
        length: "long".into(),
        covariates: "apart".into(),
        scene: "a month of an observatory".into(),
        readings: 3 * count,
        recorded: Vec::new(),
        noise_nt,
        effects,
        without: Vec::new(),
        nonce: nonce(&mut draw),
    };
    Case { document, truth }
}

/// Flicker noise of a long record, day by day: levels between the days do not wander.
fn flicker_by_pieces(noise: &Noise, count: usize, draw: &mut Draw) -> Vec<f64> {
    let days = count / 1440;
    (0..days).flat_map(|_| noise.series(1440, STEP_S, draw)).collect()
}

/// A quiet day's course, substorms, and what is faster, each with its own periods.
fn natural(draw: &mut Draw) -> Signal {
    let day = 86_400.0;
    let quiet = sines(vec![
        (18.0, day, draw.between(0.0, 6.0)),
        (9.0, day / 2.0, draw.between(0.0, 6.0)),
        (4.0, day / 3.0, draw.between(0.0, 6.0)),
    ]);
    let slow = wandering(draw, 12.0, [day, 6.0 * day], 4);
    let middle = wandering(draw, 8.0, [3600.0, 18_000.0], 8);
    let quick = wandering(draw, 2.5, [500.0, 2400.0], 8);
    mixed(vec![(1.0, quiet), (1.0, slow), (1.0, middle), (1.0, quick)])
}

/// A cellar in spring: a daily wave and the weather.
fn room(draw: &mut Draw) -> Signal {
    let day = 86_400.0;
    let daily = sines(vec![(0.7, day, draw.between(0.0, 6.0))]);
    let weather = wandering(draw, 1.8, [3.0 * day, 20.0 * day], 5);
    let rise: Signal = Arc::new(move |t| 4.0 * (t / (30.0 * day) - 0.5));
    over(18.0, mixed(vec![(1.0, daily), (1.0, weather), (1.0, rise)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_month_is_written() {
        let case = month(1);
        let rows = case.document["recordings"][0]["columns"]["test_z_nt"].as_array().map_or(0, Vec::len);
        assert_eq!(rows, DAYS * 1440);
        assert_eq!(case.truth.effects.len(), 3);
    }
}
