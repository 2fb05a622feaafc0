//! One effect left out at a time: it is named, its parameters are met, and what is left is the noise.

use common::{Diagnosis, Verdict};
use serde_json::{Value, json};

use crate::bench::{Scene, diagnosed, longer, noise, scaled, simulated, target, worst_sigma};

/// Every effect of the catalogue that a calibration does not hold already, on a recording that shows it.
pub fn cases() -> Vec<(Scene, Value)> {
    let line = |frequency: f64| {
        json!({"north_sine_nt": 1.0, "north_cosine_nt": 0.5, "east_sine_nt": 0.2, "east_cosine_nt": -0.7, "down_sine_nt": 0.4,
            "down_cosine_nt": 0.3, "frequency_hz": frequency})
    };
    let mut wanders = line(30.0);
    wanders["end_ratio"] = json!(1.02);
    let wheel = json!({"x_sine_nt": 1.0, "x_cosine_nt": 0.5, "y_sine_nt": 0.2, "y_cosine_nt": -0.7, "z_sine_nt": 0.4, "z_cosine_nt": 0.3});
    let pass = json!({"north_first_nt": 20.0, "east_first_nt": 10.0, "down_first_nt": -15.0, "north_second_nt": 10.0,
        "east_second_nt": -20.0, "down_second_nt": 5.0, "north_third_nt": 10.0, "east_third_nt": 5.0, "down_third_nt": 20.0,
        "time_s": 41000.0, "duration_s": 800.0});
    let sun = json!({"x_lit_nt": 0.5, "x_cosine_nt": 1.0, "x_sine_nt": 0.4, "x_up_nt": 0.2, "y_lit_nt": 0.1,
        "y_cosine_nt": -0.6, "y_sine_nt": 0.3, "y_up_nt": 0.5, "z_lit_nt": -0.4, "z_cosine_nt": 0.2, "z_sine_nt": 0.7, "z_up_nt": 0.1});
    let leakage = json!({"north_ppm": 5000.0, "east_ppm": 3000.0, "down_ppm": 9000.0, "lag_s": 300.0});
    let across = json!({"north_ppm": 5000.0, "east_ppm": 3000.0, "down_ppm": 9000.0, "lag_s": 300.0,
        "north_from_east_ppm": 20000.0, "north_from_down_ppm": -10000.0, "east_from_north_ppm": -20000.0,
        "east_from_down_ppm": 15000.0, "down_from_north_ppm": 10000.0, "down_from_east_ppm": -15000.0});
    let all = json!([
        ["Runs", "quadratic_nonlinearity", "sensor", "x", {"departure_nt": 3.0}],
        ["Runs", "cubic_nonlinearity", "sensor", "y", {"departure_nt": 3.0}],
        ["Runs", "cross_field", "sensor", "z", {"first_nt": 4.0, "second_nt": -2.0, "mixed_nt": 1.0}],
        ["Runs", "cross_field_sensitivity", "sensor", "x", {"first_nt": 4.0, "second_nt": 3.0}],
        ["Runs", "offset_temperature", "sensor", "x", {"coefficient_nt_per_k": 0.2, "curvature_nt_per_k2": 0.01}],
        ["Runs", "offset_temperature_lag", "sensor", "y", {"coefficient_nt_per_k": 0.2, "lag_s": 300.0}],
        ["Runs", "sensitivity_temperature", "sensor", "z", {"coefficient_ppm_per_k": 20.0, "curvature_ppm_per_k2": 0.5}],
        ["Runs", "sensitivity_temperature_lag", "sensor", "x", {"coefficient_ppm_per_k": 20.0, "lag_s": 300.0}],
        ["Runs", "axis_temperature", "sensor", "y", {"first_arcsec_per_k": 1.0, "second_arcsec_per_k": 0.5}],
        ["Runs", "axis_creep", "sensor", "z", {"first_arcsec_per_k": 1.0, "second_arcsec_per_k": -0.5, "lag_s": 250.0}],
        ["Runs", "hysteresis", "sensor", "z", {"amplitude_nt": 1.0, "coercivity_nt": 3000.0}],
        ["Runs", "perming", "sensor", "y", {"remanence_ppm": 100.0, "threshold_nt": 15000.0}],
        ["Runs", "warm_up", "sensor", "x", {"amplitude_nt": 3.0, "time_constant_s": 700.0}],
        ["Days", "ageing", "sensor", "y", {"rate_nt_per_day": 0.3}],
        ["Days", "sensitivity_ageing", "sensor", "x", {"rate_ppm_per_day": 10.0}],
        ["Runs", "offset_electronics_temperature", "sensor", "z", {"coefficient_nt_per_k": 0.2, "curvature_nt_per_k2": 0.01}],
        ["Runs", "offset_electronics_temperature_lag", "sensor", "x", {"coefficient_nt_per_k": 0.2, "lag_s": 150.0}],
        ["Runs", "sensitivity_electronics_temperature", "sensor", "y", {"coefficient_ppm_per_k": 20.0, "curvature_ppm_per_k2": 0.5}],
        ["Runs", "sensitivity_electronics_temperature_lag", "sensor", "z", {"coefficient_ppm_per_k": 20.0, "lag_s": 150.0}],
        ["Runs", "loop_bandwidth", "sensor", "x", {"lag_s": 0.05}],
        ["Runs", "delay", "sensor", "y", {"delay_s": 0.05}],
        ["Runs", "quantisation", "sensor", "z", {"width_nt": 1.0}],
        ["Runs", "differential_nonlinearity", "sensor", "x", {"sine_nt": 1.0, "cosine_nt": 0.6, "period_nt": 9000.0}],
        ["Runs", "saturation", "sensor", "y", {"level_nt": 70000.0}],
        ["Runs", "clipping", "sensor", "x", {"level_nt": 29990.0}],
        ["Runs", "clock_offset", "", "", {"offset_s": 0.01}],
        ["Runs", "clock_rate", "", "", {"rate_ppm": 3.0}],
        ["Runs", "reading_step", "sensor", "z", {"height_nt": 2.0, "time_s": 2700.0}],
        ["Runs", "spike", "sensor", "y", {"height_nt": 20.0, "time_s": 2500.0}],
        ["Runs", "dropout", "sensor", "x", {"time_s": 2500.0, "duration_s": 60.0}],
        ["Runs", "coil_temperature", "coil", "z", {"coefficient_ppm_per_k": 10.0}],
        ["Runs", "coil_heating", "coil", "x", {"fall_ppm_per_a2": 50.0, "lag_s": 600.0}],
        ["Runs", "eddy_currents", "coil", "y", {"share_ppm": 100.0, "time_constant_s": 60.0}],
        ["Site", "nulling_leakage", "", "", leakage],
        ["Runs", "coil_gradient", "coil", "x", {"gradient_ppm_per_m": 100.0}],
        ["Cube", "off_centre", "", "", {"x_m": 0.001, "y_m": 0.002, "z_m": -0.001}],
        ["Fast", "mains", "", "", line(50.02)],
        ["Fast", "traction_power", "", "", line(16.68)],
        ["Site", "vehicle_pass", "", "", pass],
        ["Site", "working_hours", "", "", {"north_nt": 2.0, "east_nt": -1.0, "down_nt": 1.0}],
        ["Site", "measured_tilt", "", "", {"gain_ppm": 900000.0}],
        ["Craft", "stray_current", "column", "panel_current_a", {"x_nt_per_a": 3.0, "y_nt_per_a": -1.0, "z_nt_per_a": 2.0}],
        ["Craft", "reaction_wheel", "column", "wheel_hz", wheel],
        ["Craft", "reaction_wheel_harmonic", "column", "wheel_hz", wheel],
        ["Craft", "sun_thermoelectric", "", "", sun],
        ["Runs", "offset_temperature_inflection", "sensor", "z", {"coefficient_nt_per_k": 0.05, "half_change_nt_per_k": 0.3, "inflection_k": 297.0, "width_k": 1.5}],
        ["Runs", "coil_heating", "coil", "z", {"fall_ppm_per_a2": 50.0, "fall_at_start_ppm_per_a2": 50.0, "lag_s": 400.0}],
        ["Site", "working_hours", "", "", {"north_nt": 2.0, "east_nt": -1.0, "down_nt": 1.0, "slack_s": 1200.0}],
        ["Site", "nulling_leakage_across", "", "", across],
        ["Fast", "periodic_field", "", "", wanders],
    ]);
    let scenes = [Scene::Runs, Scene::Cube, Scene::Days, Scene::Fast, Scene::Site, Scene::Craft];
    let case = |case: &Value| {
        let scene = scenes.into_iter().find(|scene| case[0] == format!("{scene:?}")).expect("a scene");
        let mut effect = json!({"effect": case[1], "parameters": case[4]});
        if let Some(key) = case[2].as_str().filter(|key| !key.is_empty()) {
            effect[key] = case[3].clone();
        }
        (scene, effect)
    };
    all.as_array().expect("cases").iter().map(case).collect()
}

/// What a simpler effect says as well, so that it is named.
const SHORT: [(&str, f64); 4] = [
    // A level that cuts a single reading, which is the only one to know of it.
    ("clipping x", 3.0),
    ("offset_temperature_inflection z", 1.0),
    ("offset_temperature_inflection z", 0.3),
    ("offset_electronics_temperature_lag x", 0.3),
];

/// No parameter may be farther from the truth than this many standard uncertainties: of some 150 in all the
/// cases, one would be in a run of a thousand.
const FARTHEST: f64 = 4.5;
/// What is left of readings that were left out may exceed the noise by this share: three standard deviations
/// of an rms of 480 rows.
const ABOVE_NOISE: f64 = 1.1;

/// The effect as it was scaled, and what comes of it.
fn run(which: Scene, effect: &Value, times: f64, seed: u64) -> (Value, Diagnosis) {
    // Long enough to show it: energy grows with the rows.
    longer(if times < 1.0 { 5 } else { 1 });
    let effect = scaled(which, effect, times);
    let (entry, found) = diagnosed(simulated(which, std::slice::from_ref(&effect), &noise(), seed));
    if std::env::var("FLUXCAL_EFFECT").is_ok() {
        println!("{effect}\n{}", diagnose::summary(&found));
    }
    (effect, entry)
}

/// One case in eight, or all with `FLUXCAL_CASES=all`, at 3 times the noise, or at `FLUXCAL_TIMES` of it;
/// with `FLUXCAL_TABLE` as a table for the docs.
#[test]
fn effects_are_named() {
    let only = std::env::var("FLUXCAL_EFFECT").ok();
    let times: Vec<f64> = match std::env::var("FLUXCAL_TIMES") {
        Ok(list) => list.split(',').map(|t| t.parse().expect("a number")).collect(),
        Err(_) => vec![3.0],
    };
    let mut wrong = Vec::new();
    let mut table = format!(
        "| effect | {} |\n| --- |{}\n",
        times.iter().map(|t| format!("{t} × noise")).collect::<Vec<_>>().join(" | "),
        " --- |".repeat(times.len())
    );
    let cases: Vec<_> = cases().into_iter().enumerate().collect();
    for (number, (which, effect)) in if only.is_some() { cases } else { testkit::some(cases, 8) } {
        if only.as_ref().is_some_and(|only| effect["effect"] != **only) {
            continue;
        }
        let name = target(&effect);
        table += &format!("| `{name}` |");
        for times in &times {
            let (effect, entry) = run(which, &effect, *times, 11 + number as u64);
            let named: Vec<String> = entry.effects.iter().map(|effect| target(&json!(effect))).collect();
            let fit = entry.fit.expect("a fit");
            let left = fit.held_out_after_nt / fit.noise_floor_nt;
            let sigma = entry.effects.first().map_or(f64::NAN, |own| worst_sigma(&own.parameters, &effect));
            let explained = matches!(entry.verdict, Verdict::Explained | Verdict::PartlyExplained);
            let right = explained && named == [name.clone()];
            let held = entry.ambiguity.iter().flatten().any(|member| *member == name);
            // One cell of the table in the docs.
            let figures = format!("({sigma:.1} σ, {left:.3})");
            let cell = match entry.verdict {
                Verdict::Explained if right => format!("named {figures}"),
                Verdict::PartlyExplained if right => format!("named, something left {figures}"),
                Verdict::Ambiguous if held => format!("one of {}", entry.ambiguity.len()),
                Verdict::Agrees => "not seen".into(),
                Verdict::Unexplained => "unexplained".into(),
                verdict => format!("{}: {}", verdict.word().replace('_', " "), named.join(", ")),
            };
            println!("{name:45} ×{times:<4} {cell}");
            table += &format!(" {cell} |");
            let silent = matches!(entry.verdict, Verdict::Agrees | Verdict::Unexplained);
            let short = SHORT.contains(&(name.as_str(), *times));
            if !(right || held || short || (silent && *times < 3.0)) {
                wrong.push(format!("{name} ×{times}: {named:?}"));
            }
            if right && (sigma.is_nan() || sigma > FARTHEST) {
                wrong.push(format!("{name} ×{times}: a parameter is {sigma:.1} standard uncertainties off"));
            }
            // The only reading to know of a clipping's level is the one it cut, and that may be among those
            // left out.
            let predicts = right && entry.verdict == Verdict::Explained && name != "clipping x";
            if predicts && (left.is_nan() || left > ABOVE_NOISE) {
                wrong.push(format!("{name} ×{times}: {left:.3} times the noise is left"));
            }
        }
        table.push('\n');
    }
    if let Ok(path) = std::env::var("FLUXCAL_TABLE") {
        std::fs::write(path, table).expect("written");
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
