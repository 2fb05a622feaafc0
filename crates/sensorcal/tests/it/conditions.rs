//! Temperatures and fields across.

use common::{Axis, TemperatureFit};
use noise::Stream;
use serde_json::{Value, json};

use crate::build::{self, COIL, K, change, found, near, read, recording, sensor, sweep, with};

/// Eleven fields at each of the temperatures, a reading every 11 s, half an hour between; `adds` gives nT for
/// field, temperature of the sensor and of the electronics.
fn heated(seed: u64, id: &str, steps: &[(f64, f64)], adds: impl Fn(f64, f64, f64) -> f64) -> Value {
    let mut stream = Stream::new(seed, id);
    let mut rows = Vec::new();
    let mut clock = 0.0;
    for (s, e) in steps {
        clock += 1800.0;
        for field in sweep(50_000.0, 11) {
            let volts = read(&mut stream, field + adds(field, s - 23.0, e - 23.0), 0.0, 0.1);
            rows.push([clock, field / COIL, volts, *s, *e]);
            clock += 11.0;
        }
    }
    run(id, rows)
}

/// A temperature run by rows: time, current, reading, temperatures of sensor and electronics.
fn run(id: &str, rows: Vec<[f64; 5]>) -> Value {
    let names = ["time_s", "coil_x_a", "sensor_x_v", "sensor_temperature_c", "electronics_temperature_c"];
    let column = |at: usize| (names[at], rows.iter().map(|row| row[at]).collect());
    recording(id, "temperature_run", &[0, 1, 2, 3, 4].map(column))
}

fn document(recordings: Vec<Value>) -> Value {
    let mut document = with(recordings);
    document["instrument"]["noise"] = json!({"white_rms_nt": 0.1});
    document["calibration"]["reference_conditions"] =
        json!({"sensor_temperature_c": 23.0, "electronics_temperature_c": 23.0});
    document
}

const STEPS: [f64; 13] = [0.0, 5.0, 15.0, 30.0, 15.0, 5.0, 0.0, -5.0, -15.0, -30.0, -15.0, -5.0, 0.0];

fn sensor_steps() -> Vec<(f64, f64)> {
    STEPS.iter().map(|step| (23.0 + step, 23.0)).collect()
}

fn fitted(document: &Value) -> TemperatureFit {
    *sensor(document).temperature.expect("temperatures")
}

#[test]
fn branches_that_differ_are_told() {
    // 2 nT more on the way down: the readings themselves do not say the way, their order does.
    let steps = sensor_steps();
    let mut run = heated(2, "run", &steps, |_, s, _| 0.05 * s);
    let cooling = |level: usize| level >= 1 && STEPS[level] < STEPS[level - 1];
    change(&mut run, "sensor_x_v", |row, volts| volts + if cooling(row / 11) { 2.0 / K } else { 0.0 });
    let fit = fitted(&document(vec![run]));
    assert_eq!(found(&fit.departures), ["sensor_offset_branches"]);
}

#[test]
fn temperatures_that_move_together_give_no_slopes() {
    let both: Vec<(f64, f64)> = STEPS.iter().map(|step| (23.0 + step, 23.0 + 0.98 * step)).collect();
    let fit = fitted(&document(vec![heated(3, "run", &both, |_, s, e| 0.05 * s - 0.02 * e)]));
    assert!(fit.sensor.is_none() && fit.electronics.is_none());
    assert!(fit.findings.iter().any(|finding| finding.contains("varied together")), "{:?}", fit.findings);
}

#[test]
fn both_parts_apart_and_their_product() {
    let electronics: Vec<(f64, f64)> = STEPS.iter().map(|step| (23.0, 23.0 + step)).collect();
    let cross: Vec<(f64, f64)> =
        [(0.0, 0.0), (20.0, 20.0), (-20.0, 20.0), (20.0, -20.0), (-20.0, -20.0), (0.0, 0.0)]
            .iter()
            .map(|(s, e)| (23.0 + s, 23.0 + e))
            .collect();
    let adds = |b: f64, s: f64, e: f64| 1e-6 * b * (28.0 * s + 3.0 * e) + 0.05 * s - 0.02 * e + 0.003 * s * e;
    let runs = vec![
        heated(4, "sensor", &sensor_steps(), adds),
        heated(4, "electronics", &electronics, adds),
        heated(4, "both", &cross, adds),
    ];
    let fit = fitted(&document(runs));
    assert_eq!(found(&fit.departures), ["offset_product"]);
    let product = &fit.departures.iter().find(|d| d.found).expect("found").parameter["product_nt_per_k2"];
    assert!(near(product, 0.003, 3.5));
    let electronics = fit.electronics.expect("the electronics");
    assert!((electronics.sensitivity_ppm_per_k.value() - 3.0).abs() < 0.2);
}

/// Seven fields along at each field across, from both sides by a quarter turn; the sensor leans by 20″.
fn across(seed: u64, levels: &[f64], even: f64) -> Vec<Value> {
    let lean = 20.0 / 206_264.8;
    let turn = |name: &str, orientation: Value, even: f64| {
        let mut stream = Stream::new(seed, name);
        let (mut along, mut side, mut volts) = (Vec::new(), Vec::new(), Vec::new());
        for level in levels {
            for field in sweep(50_000.0, 7) {
                along.push(field / COIL);
                side.push(level / COIL);
                let own = field + lean * level + even * (level / 5e4).powi(2);
                volts.push(read(&mut stream, own, 0.0, 0.1));
            }
        }
        let rows = along.len();
        let time = (0..rows).map(|row| 11.0 * row as f64).collect();
        let columns = [("time_s", time), ("coil_x_a", along), ("coil_z_a", side), ("sensor_x_v", volts)];
        let mut one = recording(name, "cross_field", &columns);
        one["conditions"]["orientation"] = orientation;
        one
    };
    vec![
        turn("as-it-is", json!([[1, 0, 0], [0, 1, 0], [0, 0, 1]]), even),
        turn("turned", json!([[1, 0, 0], [0, 0, -1], [0, 1, 0]]), 0.0),
    ]
}

#[test]
fn a_lean_is_not_taken_for_an_effect_of_fields_across() {
    let levels = [-60_000.0, -20_000.0, 0.0, 20_000.0, 60_000.0];
    let found = build::run(&document(across(6, &levels, 0.0))).expect("calibrated");
    let leaning = build::of(&found, Axis::X).cross_field.as_ref().expect("transverse fields");
    assert!(leaning.significance.expect("a test").p_value > 0.01);
    for misalignment in &leaning.misalignments {
        assert!(near(&misalignment.angle_arcsec, 20.0, 3.5), "{misalignment:?}");
    }
    assert!(found.model.is_none_or(|model| model.effects.is_empty()));
    // An effect that is even in the field along z (v in SEN); the field from the other side (u) does nothing.
    let small = [-20_000.0, -10_000.0, 0.0, 10_000.0, 20_000.0];
    for (seed, levels, nt, p) in [(6, levels, 3.0, 1e-10), (22, small, 8.0, 1e-6)] {
        let acting = sensor(&document(across(seed, &levels, nt))).cross_field.expect("transverse fields");
        let (first, second) = (&acting.offset["first_nt"], &acting.offset["second_nt"]);
        assert!(near(second, nt, 3.5) && near(first, 0.0, 3.5), "{first:?} {second:?}");
        assert!(acting.significance.expect("a test").p_value < p);
        assert!(acting.difference.expect("a test").p_value < p);
    }
}

#[test]
fn one_side_alone_is_said() {
    let one = across(7, &[-60_000.0, 0.0, 60_000.0], 3.0).remove(0);
    let cross = sensor(&document(vec![one])).cross_field.expect("transverse fields");
    assert!(cross.offset.contains_key("second_nt") && !cross.offset.contains_key("first_nt"));
    let said = cross.findings.join("\n");
    assert!(said.contains("was not recorded"), "{said}");
}

#[test]
fn without_both_signs_a_lean_cannot_be_told() {
    let cross = sensor(&document(across(8, &[0.0, 60_000.0], 3.0))).cross_field.expect("transverse fields");
    assert!(cross.offset.is_empty());
    assert!(cross.findings.iter().any(|finding| finding.contains("both signs")), "{:?}", cross.findings);
}

#[test]
fn a_ramp_shows_its_curvature_and_no_lag() {
    let mut stream = Stream::new(21, "ramp");
    let adds = |b: f64, s: f64| b * 1e-6 * (28.0 * s + 0.05 * s * s) + 0.05 * s + 0.001 * s * s;
    let rows = (0..301).map(|row| {
        let (field, sensor) = (50_000.0 * f64::from(row % 11) / 5.0 - 50_000.0, -7.0 + 0.2 * f64::from(row));
        let volts = read(&mut stream, field + adds(field, sensor - 23.0), 0.0, 0.1);
        [60.0 * f64::from(row), field / COIL, volts, sensor, 23.0]
    });
    let ramp = run("ramp", rows.collect());
    let part = fitted(&document(vec![ramp])).sensor.expect("the sensor");
    let curvature = part.sensitivity_ppm_per_k2.expect("a curvature");
    assert!(near(&curvature, 0.05, 3.5), "{curvature:?}");
    assert!(part.lag_s.is_none(), "{}", part.lag);
}
