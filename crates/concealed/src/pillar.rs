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
/// 0 degC in K.
const ZERO_C: f64 = 273.15;

/// The month of a seed.
///
/// The variometer's y has a temperature coefficient that changes sign at an inflection,
///
/// ```text
/// dB_y = c (√((T − T_1)² + w²) − w)
/// ```
///
/// its clock is some seconds late, and its z steps once. Sizes as Jankowski and Sucksdorff 1996 (IAGA Guide for Magnetic Measurements and
/// Observatory Practice) have them for paired variometers: 1.5 to 3 nT apart over a day.
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
        noise_nt,
        effects,
        baselines: Default::default(),
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

/// What the two stages made of the month.
pub fn section(truth: &Truth, compared: &Value, answer: &Value) -> String {
    let of = |which: usize, key: &str| truth.effects[which].parameters[key].as_f64().unwrap_or(f64::NAN);
    let differential = &compared["calibration"]["differential"]["fit"];
    let list = |value: &Value| -> Vec<String> {
        let all = value.as_array().into_iter().flatten();
        all.filter_map(|one| one.as_str().map(str::to_string)).collect()
    };
    let entry = &answer["diagnosis"][0];
    let fit = |key: &str| entry["fit"][key].as_f64().unwrap_or(f64::NAN);
    let mut text = format!(
        "## A month of an observatory\n\n\
        A variometer beside the reference, {} rows of a minute. Concealed: on y an offset whose slope changes sign at {:.2} K (± {:.2} nT/K far from it, along a hyperbola), a clock {:.2} s late, \
        on z one step of {:.2} nT after {:.2} days. Noise {:.3} nT.\n\n`diffmag --correct-clock` says of it:\n\n",
        truth.readings / 3,
        of(0, "inflection_c") + ZERO_C,
        of(0, "slope_nt_per_k"),
        of(1, "offset_s"),
        of(2, "height_nt"),
        of(2, "time_s") / 86_400.0,
        truth.noise_nt
    );
    let quantity = |of: &Value| {
        let part = |key: &str| of[key].as_f64().unwrap_or(f64::NAN);
        format!("{:.3} ± {:.3}", part("value"), part("std"))
    };
    text += &format!("- the clocks differ by {} s\n", quantity(&differential["clock"]["offset_s"]));
    for event in differential["kept_out"]["events"].as_array().into_iter().flatten() {
        text += &format!(
            "- a {} on {} of {} nT after {:.2} days\n",
            event["kind"].as_str().unwrap_or_default(),
            event["axis"].as_str().unwrap_or_default(),
            quantity(&event["size_nt"]),
            event["time_s"].as_f64().unwrap_or(f64::NAN) / 86_400.0
        );
    }
    for finding in list(&differential["findings"]).iter().filter(|words| words.starts_with("axis y")) {
        text += &format!("- {finding}\n");
    }
    text += &format!(
        "\n`diagnose`, given that calibration, and the clock in its model: **{}**; rms {:.3} nT with the calibration fitted again, {:.3} nT with what was found, readings left out {:.3} nT.\n\n",
        entry["verdict"].as_str().unwrap_or("none").replace('_', " "),
        fit("rms_refitted_nt"),
        fit("rms_after_nt"),
        fit("held_out_after_nt")
    );
    for effect in entry["effects"].as_array().into_iter().flatten() {
        let target =
            ["sensor", "coil", "column"].iter().find_map(|key| effect[*key].as_str()).unwrap_or("all");
        let parameters: Vec<String> = effect["parameters"]
            .as_object()
            .into_iter()
            .flatten()
            .filter_map(|(name, found)| {
                let (value, std) = (found["value"].as_f64()?, found["std"].as_f64().unwrap_or(0.0));
                Some(format!("{name} = {value:.4} ± {std:.4}"))
            })
            .collect();
        text += &format!(
            "- `{}` of {target}: {}\n",
            effect["effect"].as_str().unwrap_or_default(),
            parameters.join(", ")
        );
    }
    for place in entry["where"].as_array().into_iter().flatten() {
        let share = place["energy_share"].as_f64();
        let share = share.map_or(String::new(), |share| format!(", {:.0} % of the energy", 100.0 * share));
        text += &format!("- where: {}{share}\n", place["description"].as_str().unwrap_or_default());
    }
    for reason in list(&entry["reasons"]).iter().filter(|words| words.starts_with("not ")) {
        text += &format!("- {reason}\n");
    }
    let sets: Vec<String> =
        entry["ambiguity"].as_array().into_iter().flatten().map(|set| list(set).join(" with ")).collect();
    if !sets.is_empty() {
        text += &format!("\nTold as equals: {}.\n", sets.join("; "));
    }
    text
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
