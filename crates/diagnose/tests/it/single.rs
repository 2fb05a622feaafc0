//! One effect left out at a time: it is named, its parameters are met, and what is left is the noise.

use crate::bench;

use bench::{Scene, noise, scaled, simulated, target, worst_sigma};
use common::Verdict;
use diagnose::Options;
use serde_json::{Value, json};

/// Every effect of the catalogue that a calibration does not hold already, on a recording that shows it.
pub fn cases() -> Vec<(Scene, Value)> {
    let one = |effect: &str, sensor: &str, parameters: Value| json!({"effect": effect, "sensor": sensor, "parameters": parameters});
    let coil = |effect: &str, coil: &str, parameters: Value| json!({"effect": effect, "coil": coil, "parameters": parameters});
    let all = |effect: &str, parameters: Value| json!({"effect": effect, "parameters": parameters});
    let column = |effect: &str, column: &str, parameters: Value| json!({"effect": effect, "column": column, "parameters": parameters});
    let line = |frequency: f64| {
        json!({"north_sine_nt": 1.0, "north_cosine_nt": 0.5, "east_sine_nt": 0.2, "east_cosine_nt": -0.7, "down_sine_nt": 0.4,
            "down_cosine_nt": 0.3, "frequency_hz": frequency})
    };
    let wheel = json!({"x_sine_nt": 1.0, "x_cosine_nt": 0.5, "y_sine_nt": 0.2, "y_cosine_nt": -0.7, "z_sine_nt": 0.4, "z_cosine_nt": 0.3});
    vec![
        (Scene::Runs, one("quadratic_nonlinearity", "x", json!({"departure_nt": 3.0}))),
        (Scene::Runs, one("cubic_nonlinearity", "y", json!({"departure_nt": 3.0}))),
        (Scene::Runs, one("cross_field", "z", json!({"first_nt": 4.0, "second_nt": -2.0, "mixed_nt": 1.0}))),
        (Scene::Runs, one("cross_field_sensitivity", "x", json!({"first_nt": 4.0, "second_nt": 3.0}))),
        (
            Scene::Runs,
            one("offset_temperature", "x", json!({"coefficient_nt_per_k": 0.2, "curvature_nt_per_k2": 0.01})),
        ),
        (
            Scene::Runs,
            one("offset_temperature_lag", "y", json!({"coefficient_nt_per_k": 0.2, "lag_s": 300.0})),
        ),
        (
            Scene::Runs,
            one(
                "sensitivity_temperature",
                "z",
                json!({"coefficient_ppm_per_k": 20.0, "curvature_ppm_per_k2": 0.5}),
            ),
        ),
        (
            Scene::Runs,
            one("sensitivity_temperature_lag", "x", json!({"coefficient_ppm_per_k": 20.0, "lag_s": 300.0})),
        ),
        (
            Scene::Runs,
            one("axis_temperature", "y", json!({"first_arcsec_per_k": 1.0, "second_arcsec_per_k": 0.5})),
        ),
        (
            Scene::Runs,
            one(
                "axis_creep",
                "z",
                json!({"first_arcsec_per_k": 1.0, "second_arcsec_per_k": -0.5, "lag_s": 250.0}),
            ),
        ),
        (Scene::Runs, one("hysteresis", "z", json!({"amplitude_nt": 1.0, "coercivity_nt": 3000.0}))),
        (Scene::Runs, one("perming", "y", json!({"remanence_ppm": 100.0, "threshold_nt": 15000.0}))),
        (Scene::Runs, one("warm_up", "x", json!({"amplitude_nt": 3.0, "time_constant_s": 700.0}))),
        (Scene::Days, one("ageing", "y", json!({"rate_nt_per_day": 0.3}))),
        (Scene::Days, one("sensitivity_ageing", "x", json!({"rate_ppm_per_day": 10.0}))),
        (
            Scene::Runs,
            one(
                "offset_electronics_temperature",
                "z",
                json!({"coefficient_nt_per_k": 0.2, "curvature_nt_per_k2": 0.01}),
            ),
        ),
        (
            Scene::Runs,
            one(
                "offset_electronics_temperature_lag",
                "x",
                json!({"coefficient_nt_per_k": 0.2, "lag_s": 150.0}),
            ),
        ),
        (
            Scene::Runs,
            one(
                "sensitivity_electronics_temperature",
                "y",
                json!({"coefficient_ppm_per_k": 20.0, "curvature_ppm_per_k2": 0.5}),
            ),
        ),
        (
            Scene::Runs,
            one(
                "sensitivity_electronics_temperature_lag",
                "z",
                json!({"coefficient_ppm_per_k": 20.0, "lag_s": 150.0}),
            ),
        ),
        (Scene::Runs, one("loop_bandwidth", "x", json!({"lag_s": 0.05}))),
        (Scene::Runs, one("delay", "y", json!({"delay_s": 0.05}))),
        (Scene::Runs, one("quantisation", "z", json!({"width_nt": 1.0}))),
        (
            Scene::Runs,
            one(
                "differential_nonlinearity",
                "x",
                json!({"sine_nt": 1.0, "cosine_nt": 0.6, "period_nt": 9000.0}),
            ),
        ),
        (Scene::Runs, one("saturation", "y", json!({"level_nt": 70000.0}))),
        (Scene::Runs, one("clipping", "x", json!({"level_nt": 29990.0}))),
        (Scene::Runs, all("clock_offset", json!({"offset_s": 0.01}))),
        (Scene::Runs, all("clock_rate", json!({"rate_ppm": 3.0}))),
        (Scene::Runs, one("reading_step", "z", json!({"height_nt": 2.0, "time_s": 2700.0}))),
        (Scene::Runs, one("spike", "y", json!({"height_nt": 20.0, "time_s": 2500.0}))),
        (Scene::Runs, one("dropout", "x", json!({"time_s": 2500.0, "duration_s": 60.0}))),
        (Scene::Runs, coil("coil_temperature", "z", json!({"coefficient_ppm_per_k": 10.0}))),
        (Scene::Runs, coil("coil_heating", "x", json!({"fall_ppm_per_a2": 50.0, "lag_s": 600.0}))),
        (Scene::Runs, coil("eddy_currents", "y", json!({"share_ppm": 100.0, "time_constant_s": 60.0}))),
        (
            Scene::Site,
            all(
                "nulling_leakage",
                json!({"north_ppm": 5000.0, "east_ppm": 3000.0, "down_ppm": 9000.0, "lag_s": 300.0}),
            ),
        ),
        (Scene::Runs, coil("coil_gradient", "x", json!({"gradient_ppm_per_m": 100.0}))),
        (Scene::Cube, all("off_centre", json!({"x_m": 0.001, "y_m": 0.002, "z_m": -0.001}))),
        (Scene::Fast, all("mains", line(50.02))),
        (Scene::Fast, all("traction_power", line(16.68))),
        (
            Scene::Site,
            all(
                "vehicle_pass",
                json!({"north_first_nt": 20.0, "east_first_nt": 10.0, "down_first_nt": -15.0, "north_second_nt": 10.0,
            "east_second_nt": -20.0, "down_second_nt": 5.0, "north_third_nt": 10.0, "east_third_nt": 5.0, "down_third_nt": 20.0,
            "time_s": 41000.0, "duration_s": 800.0}),
            ),
        ),
        (Scene::Site, all("working_hours", json!({"north_nt": 2.0, "east_nt": -1.0, "down_nt": 1.0}))),
        (Scene::Site, all("measured_tilt", json!({"gain_ppm": 900000.0}))),
        (
            Scene::Craft,
            column(
                "stray_current",
                "panel_current_a",
                json!({"x_nt_per_a": 3.0, "y_nt_per_a": -1.0, "z_nt_per_a": 2.0}),
            ),
        ),
        (Scene::Craft, column("reaction_wheel", "wheel_hz", wheel.clone())),
        (Scene::Craft, column("reaction_wheel_harmonic", "wheel_hz", wheel)),
        (
            Scene::Craft,
            all(
                "sun_thermoelectric",
                json!({"x_lit_nt": 0.5, "x_cosine_nt": 1.0, "x_sine_nt": 0.4, "x_up_nt": 0.2, "y_lit_nt": 0.1,
            "y_cosine_nt": -0.6, "y_sine_nt": 0.3, "y_up_nt": 0.5, "z_lit_nt": -0.4, "z_cosine_nt": 0.2, "z_sine_nt": 0.7, "z_up_nt": 0.1}),
            ),
        ),
        (
            Scene::Runs,
            one(
                "offset_temperature_inflection",
                "z",
                json!({"coefficient_nt_per_k": 0.05, "half_change_nt_per_k": 0.3, "inflection_k": 297.0, "width_k": 1.5}),
            ),
        ),
        (
            Scene::Runs,
            coil(
                "coil_heating",
                "z",
                json!({"fall_ppm_per_a2": 50.0, "fall_at_start_ppm_per_a2": 50.0, "lag_s": 400.0}),
            ),
        ),
        (
            Scene::Site,
            all(
                "working_hours",
                json!({"north_nt": 2.0, "east_nt": -1.0, "down_nt": 1.0, "slack_s": 1200.0}),
            ),
        ),
        (
            Scene::Site,
            all(
                "nulling_leakage_across",
                json!({"north_ppm": 5000.0, "east_ppm": 3000.0, "down_ppm": 9000.0, "lag_s": 300.0,
            "north_from_east_ppm": 20000.0, "north_from_down_ppm": -10000.0, "east_from_north_ppm": -20000.0,
            "east_from_down_ppm": 15000.0, "down_from_north_ppm": 10000.0, "down_from_east_ppm": -15000.0}),
            ),
        ),
        (Scene::Fast, {
            let mut wanders = all("periodic_field", line(30.0));
            wanders["parameters"]["end_ratio"] = json!(1.02);
            wanders
        }),
    ]
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

/// What came of one case.
struct Outcome {
    verdict: Verdict,
    named: Vec<String>,
    ambiguity: Vec<Vec<String>>,
    sigma: f64,
    held_out_over_floor: f64,
}

fn run(which: Scene, effect: &Value, times: f64, seed: u64) -> (Outcome, Value) {
    // Long enough to show it: energy grows with the rows.
    bench::longer(if times < 1.0 { 5 } else { 1 });
    let effect = scaled(which, effect, times);
    let document = simulated(which, std::slice::from_ref(&effect), &noise(), seed);
    let found = diagnose::run(document, &Options::default()).expect("diagnosed");
    if std::env::var("FLUXCAL_EFFECT").is_ok() {
        println!("{effect}\n{}", diagnose::summary(&found));
    }
    let entry = found.diagnosis.expect("a diagnosis").remove(0);
    let fit = entry.fit.expect("a fit");
    let outcome = Outcome {
        verdict: entry.verdict,
        named: entry.effects.iter().map(|effect| target(&json!(effect))).collect(),
        ambiguity: entry.ambiguity,
        sigma: entry.effects.first().map_or(f64::NAN, |found| worst_sigma(&found.parameters, &effect)),
        held_out_over_floor: fit.held_out_after_nt / fit.noise_floor_nt,
    };
    (outcome, effect)
}

/// One cell of the table in the docs.
fn cell(outcome: &Outcome, right: bool, held: bool) -> String {
    let answer = match outcome.verdict {
        Verdict::Explained if right => "named".to_string(),
        Verdict::PartlyExplained if right => "named, something left".to_string(),
        Verdict::Ambiguous if held => format!("one of {}", outcome.ambiguity.len()),
        Verdict::Agrees => "not seen".into(),
        Verdict::Unexplained => "unexplained".into(),
        verdict => format!("{}: {}", verdict.word().replace('_', " "), outcome.named.join(", ")),
    };
    let figures = format!("{:.1} σ, {:.3}", outcome.sigma, outcome.held_out_over_floor);
    if right { format!("{answer} ({figures})") } else { answer }
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
        table += &format!("| `{}` |", target(&effect));
        for times in &times {
            let (outcome, effect) = run(which, &effect, *times, 11 + number as u64);
            let name = target(&effect);
            let explained = matches!(outcome.verdict, Verdict::Explained | Verdict::PartlyExplained);
            let right = explained && outcome.named == [name.clone()];
            let held = outcome.ambiguity.iter().flatten().any(|member| *member == name);
            println!(
                "{name:45} ×{times:<4} {:17} {:?} {:?} worst σ {:.1} held-out/floor {:.3}",
                outcome.verdict.word(),
                outcome.named,
                outcome.ambiguity,
                outcome.sigma,
                outcome.held_out_over_floor
            );
            table += &format!(" {} |", cell(&outcome, right, held));
            let silent = matches!(outcome.verdict, Verdict::Agrees | Verdict::Unexplained);
            let short = SHORT.contains(&(name.as_str(), *times));
            let passed = right || held || short || (silent && *times < 3.0);
            if !passed {
                wrong.push(format!("{name} ×{times}: {:?}", outcome.named));
            }
            let (sigma, left) = (outcome.sigma, outcome.held_out_over_floor);
            if right && (sigma.is_nan() || sigma > FARTHEST) {
                wrong.push(format!("{name} ×{times}: a parameter is {sigma:.1} standard uncertainties off"));
            }
            // The only reading to know of a clipping's level is the one it cut, and that may be among those
            // left out.
            let predicts = right && outcome.verdict == Verdict::Explained && name != "clipping x";
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
