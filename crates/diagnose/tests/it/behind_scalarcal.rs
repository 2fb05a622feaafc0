//! Behind scalarcal: what it was not asked to fit is named by diagnose, and where nothing is hidden the two
//! agree.

use common::{Diagnosis, Document, Verdict};
use nalgebra::Vector3;
use noise::Stream;
use serde_json::{Value, json};
use std::f64::consts::TAU;

use crate::bench::{again, diagnosed, named, parsed, worst_sigma};

/// White noise of a sensor and of the scalar magnetometer, nT.
const SENSOR_NT: f64 = 0.3;
const SCALAR_NT: f64 = 0.1;
const ROWS: usize = 600;

/// Sensors turned by hand in a field of 48 µT, warmed by the Sun and a heater, in which `effects` act.
fn turned(effects: &[Value], seed: u64) -> Document {
    let field = |row: usize| {
        let part = (row as f64 + 0.5) / ROWS as f64;
        let (height, angle) = ((9.3 * TAU * part + 0.3).cos(), 31.0 * TAU * part);
        let across = (1.0 - height * height).sqrt();
        let magnitude = 48_000.0 + 40.0 * (TAU * part).sin();
        Vector3::new(across * angle.cos(), across * angle.sin(), height) * magnitude
    };
    let column = |of: &dyn Fn(f64) -> f64| (0..ROWS).map(|row| of(row as f64)).collect::<Vec<f64>>();
    let mut columns = json!({
        "time_s": column(&|t| t),
        "sensor_temperature_c": column(&|t| 23.0 + 8.0 * (t / 111.0 + 0.5).sin() + 3.0 * (t / 30.0).sin()),
        "heater_a": column(&|t| f64::from(u8::from((t / 15.5).sin() > 0.0)) + 0.3 * (t / 6.5).sin()),
    });
    for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
        columns[format!("ambient_{letter}_nt")] =
            json!((0..ROWS).map(|row| field(row)[axis]).collect::<Vec<f64>>());
        columns[format!("sensor_{letter}_nt")] = json!(vec![0.0; ROWS]);
    }
    let sensor = |k: f64, offset_nt: f64| json!({"sensitivity_nt_per_nt": k, "offset_nt": offset_nt});
    let truth = json!({"fluxcal": 1, "facility": {"reference_std_nt": SCALAR_NT},
        "calibration": {"sensors": {"x": sensor(1.002, 12.0), "y": sensor(0.997, -8.0), "z": sensor(1.001, 4.0)},
            "reference_conditions": {"sensor_temperature_c": 23.0},
            "axes": {"sensors": {"matrix": [[1.0, 0.0087, 0.0035], [0.0, 0.99996, -0.0052], [0.0, 0.0, 0.99998]]}}},
        "recordings": [{"id": "turned", "procedure": "free_run", "columns": columns}]});
    let mut read = again(parsed(&truth), effects, &json!({"white_rms_nt": SENSOR_NT}), seed);
    let mut stream = Stream::new(seed, "scalar");
    let scalar: Vec<f64> = (0..ROWS).map(|row| field(row).norm() + SCALAR_NT * stream.normal()).collect();
    let columns = &mut read.recordings[0].columns;
    columns.retain(|name, _| !name.starts_with("ambient_"));
    columns.insert("reference_nt".into(), scalar.into());
    let calibration = read.calibration.get_or_insert_default();
    (calibration.sensors, calibration.axes) = (None, None);
    read
}

/// scalarcal, then diagnose.
fn both(document: Document) -> (Diagnosis, Document) {
    diagnosed(scalarcal::run(document, &scalarcal::Options::default()).expect("calibrated"))
}

#[test]
fn where_nothing_is_hidden_it_agrees() {
    for seed in [1, 2] {
        let (entry, _) = both(turned(&[], seed));
        assert_eq!(entry.verdict, Verdict::Agrees, "{seed}: {:?}", entry.reasons);
    }
}

#[test]
fn what_was_not_asked_for_is_named_and_scalarcal_takes_it_off() {
    for effect in [
        json!({"effect": "offset_temperature", "sensor": "x",
            "parameters": {"coefficient_nt_per_k": 0.4, "curvature_nt_per_k2": 0.0}}),
        json!({"effect": "sensitivity_temperature", "sensor": "y",
            "parameters": {"coefficient_ppm_per_k": 20.0, "curvature_ppm_per_k2": 0.0}}),
        json!({"effect": "stray_current", "column": "heater_a",
            "parameters": {"x_nt_per_a": 3.0, "y_nt_per_a": -2.0, "z_nt_per_a": 4.0}}),
    ] {
        let (entry, found) = both(turned(std::slice::from_ref(&effect), 3));
        assert_eq!(entry.verdict, Verdict::Explained, "{effect}: {:?}", entry.reasons);
        assert_eq!(named(&entry), [effect["effect"].as_str().expect("a name")]);
        let worst = worst_sigma(&entry.effects[0].parameters, &effect);
        assert!(worst < 4.0, "{effect}: {worst} standard uncertainties");
        // With the effect in the model scalarcal's residuals are the noise, and diagnose has nothing to add.
        let (entry, found) = both(found);
        assert_eq!(entry.verdict, Verdict::Agrees, "{effect}: {:?}", entry.reasons);
        let scalar = found.calibration.and_then(|calibration| calibration.scalar).expect("a calibration");
        let noise = SENSOR_NT.hypot(SCALAR_NT);
        assert!((scalar.rms_nt / noise - 1.0).abs() < 0.1, "{effect}: {} nT", scalar.rms_nt);
    }
}
