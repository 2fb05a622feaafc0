//! A magnetometer in orbit beside a scalar one: nothing is known of the field but its length.

use common::{Document, Verdict};
use diagnose::Options;
use nalgebra::Vector3;
use noise::Stream;
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, TAU};

use crate::bench::{again, diagnosed, diagnosed_with, named, near, parsed, worst_sigma};

/// White noise of a sensor and of the scalar magnetometer, nT; both together make [`BOTH_NT`] of a
/// difference.
const SENSOR_NT: f64 = 0.12;
const SCALAR_NT: f64 = 0.09;
const BOTH_NT: f64 = 0.15;
/// Rows, and seconds between them: half a day in a low orbit.
const ROWS: usize = 2160;
const STEP_S: f64 = 20.0;
const ORBIT_S: f64 = 5640.0;
/// What the document does not know of the sensors: sensitivities, offsets in nT.
const SENSITIVITY: [f64; 3] = [1.0004, 0.9997, 1.0002];
const OFFSET_NT: [f64; 3] = [12.0, -8.0, 5.0];

/// One row in the frame of the satellite: x ahead, z down.
struct Row {
    time_s: f64,
    field_nt: Vector3<f64>,
    sun: Vector3<f64>,
    lit: f64,
    phase: f64,
}

/// A polar orbit about a tilted dipole that turns below it, the satellite librating by a degree or two.
fn orbit() -> Vec<Row> {
    let sun = Vector3::new(0.85_f64, 0.45, 0.3).normalize();
    (0..ROWS)
        .map(|row| {
            let time_s = STEP_S * row as f64;
            let (u, day) = (TAU * time_s / ORBIT_S, TAU * time_s / 86_400.0);
            let place = Vector3::new(u.cos(), 0.05 * u.sin(), u.sin()).normalize();
            let ahead = Vector3::new(-u.sin(), 0.05 * u.cos(), u.cos());
            let side = -place.cross(&ahead).normalize();
            let pole = Vector3::new(0.17 * day.cos(), 0.17 * day.sin(), -0.98).normalize();
            let field = (place * (3.0 * place.dot(&pole)) - pole) * 25_000.0
                + Vector3::new(900.0 * (2.0 * day).cos(), 700.0 * (3.0 * u).sin(), 500.0 * (day + u).cos());
            let [roll, pitch] = [0.03 * (TAU * time_s / 1700.0).sin(), 0.02 * (TAU * time_s / 2300.0).cos()];
            let turn = nalgebra::Rotation3::from_euler_angles(roll, pitch, 0.0);
            let aboard =
                |v: &Vector3<f64>| turn * Vector3::new(side.cross(&place).dot(v), side.dot(v), -place.dot(v));
            let shadow = place.dot(&sun) < 0.0 && place.cross(&sun).norm() < 0.93;
            let (field_nt, sun) = (aboard(&field), aboard(&sun));
            Row { time_s, field_nt, sun, lit: f64::from(u8::from(!shadow)), phase: u }
        })
        .collect()
}

/// What the Sun does, nT: three lobes about directions of their own, which no sum of a few harmonics is.
fn lobes(row: &Row) -> Vector3<f64> {
    let lobe = |toward: [f64; 3], size: [f64; 3]| {
        Vector3::from(size) * (1.5 * (Vector3::from(toward).normalize().dot(&row.sun) - 1.0)).exp()
    };
    let sum = lobe([1.0, 0.2, -0.3], [2.5, -1.0, 1.5])
        + lobe([-0.3, -1.0, 0.4], [1.0, 2.0, -2.5])
        + lobe([-0.8, 0.5, 0.6], [-2.0, 1.5, 1.0]);
    row.lit * sum
}

/// Readings in which `effects` act, with what `disturbance` adds to the field that the sensors see.
fn document(effects: &[Value], disturbance: impl Fn(&Row) -> Vector3<f64>, seed: u64) -> Document {
    let rows = orbit();
    let column = |of: &dyn Fn(&Row) -> f64| rows.iter().map(of).collect::<Vec<f64>>();
    let mut columns = serde_json::Map::new();
    let mut put = |name: &str, values: Vec<f64>| columns.insert(name.into(), json!(values));
    for (number, axis) in ["x", "y", "z"].into_iter().enumerate() {
        put(&format!("ambient_{axis}_nt"), column(&|row| (row.field_nt + disturbance(row))[number]));
        put(&format!("sensor_{axis}_nt"), vec![0.0; ROWS]);
    }
    put("time_s", column(&|row| row.time_s));
    put("sun_azimuth_rad", column(&|row| row.sun.y.atan2(row.sun.x)));
    put("sun_elevation_rad", column(&|row| FRAC_PI_2 - row.sun.z.acos()));
    put("eclipse", column(&|row| 1.0 - row.lit));
    put("sensor_temperature_c", column(&|row| 20.0 + 4.0 * (row.phase + 0.8).sin() + 1.5 * row.lit));
    let current = |row: &Row| row.lit * (0.3 + row.sun.x.abs()) + 0.2 * (row.time_s / 700.0).sin();
    put("panel_current_a", column(&current));
    let sensors = |k: [f64; 3], o: [f64; 3]| {
        let one = |i: usize| json!({"sensitivity_nt_per_nt": {"value": k[i], "std": 5e-4}, "offset_nt": {"value": o[i], "std": 15.0}});
        json!({"x": one(0), "y": one(1), "z": one(2)})
    };
    let truth = json!({"fluxcal": 1, "facility": {"reference_std_nt": SCALAR_NT},
        "calibration": {"sensors": sensors(SENSITIVITY, OFFSET_NT), "reference_conditions": {"sensor_temperature_c": 20.0},
            "axes": {"sensors": {"matrix": [[1.0, 0.0002, -0.0001], [0.0, 0.99999998, 0.0003], [0.0, 0.0, 0.99999995]]}}},
        "recordings": [{"id": "orbit", "procedure": "free_run", "columns": columns}]});
    let mut read = again(parsed(&truth), effects, &json!({"white_rms_nt": SENSOR_NT}), seed);
    let mut stream = Stream::new(seed, "scalar");
    let scalar: Vec<f64> = rows.iter().map(|row| row.field_nt.norm() + SCALAR_NT * stream.normal()).collect();
    let columns = &mut read.recordings[0].columns;
    columns.retain(|name, _| !name.starts_with("ambient_"));
    columns.insert("reference_nt".into(), scalar.into());
    let calibration = read.calibration.get_or_insert_default();
    calibration.sensors = serde_json::from_value(sensors([1.0; 3], [0.0; 3])).expect("sensors");
    calibration.axes = None;
    read
}

fn no_disturbance(_: &Row) -> Vector3<f64> {
    Vector3::zeros()
}

#[test]
fn nine_constants_come_back_and_a_common_turn_does_not() {
    let (entry, _) = diagnosed(document(&[], no_disturbance, 3));
    assert_eq!(entry.verdict, Verdict::Agrees, "{:?}", entry.reasons);
    let shift = |name: &str| {
        let found = entry.base_shift.iter().find(|shift| shift.parameter == name);
        found.unwrap_or_else(|| panic!("no {name} in {:?}", entry.base_shift)).shift.clone()
    };
    assert_eq!(entry.base_shift.len(), 9, "{:?}", entry.base_shift);
    for (axis, (k, o)) in ["x", "y", "z"].into_iter().zip(SENSITIVITY.into_iter().zip(OFFSET_NT)) {
        for (name, truth) in [("sensitivity", k - 1.0), ("offset_nt", o)] {
            near(&shift(&format!("sensors.{axis}.{name}")), truth, 4.0, f64::INFINITY);
        }
    }
    let turns = entry.base_shift.iter().filter(|shift| shift.parameter.contains("turn")).count();
    assert_eq!(turns, 3, "{:?}", entry.base_shift);
    let told = entry.reasons.iter().any(|reason| reason.contains("a common rotation of all sensors"));
    assert!(told, "{:?}", entry.reasons);
}

#[test]
fn what_the_sun_drives_is_found_and_taken_to_the_noise() {
    let (entry, found) = diagnosed(document(&[], lobes, 4));
    assert_eq!(entry.verdict, Verdict::Explained, "{:?} {:?}", named(&entry), entry.reasons);
    assert!(named(&entry).iter().all(|name| name.starts_with("sun_thermoelectric")), "{:?}", named(&entry));
    let fit = entry.fit.as_ref().expect("a fit");
    assert!(fit.rms_refitted_nt > 2.0 * BOTH_NT, "{fit:?}");
    assert!((fit.rms_after_nt / BOTH_NT - 1.0).abs() < 0.05, "{fit:?}");
    assert!((fit.held_out_after_nt / BOTH_NT - 1.0).abs() < 0.06, "{fit:?}");
    let place = &entry.places[0];
    assert_eq!(place.place.as_deref(), Some("spacecraft"));
    assert_eq!(place.frame.as_deref(), Some("SEN"));
    assert_eq!(place.covariates, ["sun_azimuth_rad", "sun_elevation_rad", "eclipse"]);
    let dark = entry.energy.iter().find(|share| share.by == "eclipse" && share.range == Some([1.0, 1.0]));
    let dark = dark.expect("a share of the rows in eclipse").share;
    assert!(dark.abs() < 0.05, "{dark} of the energy in eclipse");
    // The better model agrees.
    let (again, _) = diagnosed(found);
    assert_eq!(again.verdict, Verdict::Agrees, "{:?}", again.reasons);
}

/// One case in three, or all with FLUXCAL_CASES=all.
#[test]
fn what_else_shows_in_the_magnitude_has_its_name() {
    let effects = vec![
        json!({"effect": "sun_thermoelectric", "parameters": {"x_lit_nt": 0.4, "x_cosine_nt": 1.0, "x_sine_nt": -0.7, "x_up_nt": 0.5,
            "y_lit_nt": -0.6, "y_cosine_nt": 0.5, "y_sine_nt": 1.1, "y_up_nt": 0.3, "z_lit_nt": 0.8, "z_cosine_nt": -1.2,
            "z_sine_nt": 0.4, "z_up_nt": 0.9}}),
        json!({"effect": "clock_offset", "parameters": {"offset_s": 0.05}}),
        json!({"effect": "stray_current", "column": "panel_current_a",
            "parameters": {"x_nt_per_a": 2.0, "y_nt_per_a": -1.0, "z_nt_per_a": 1.5}}),
        json!({"effect": "sensitivity_temperature", "sensor": "z",
            "parameters": {"coefficient_ppm_per_k": 9.0, "curvature_ppm_per_k2": 0.0}}),
    ];
    for effect in testkit::some(effects, 3) {
        let (entry, _) = diagnosed(document(std::slice::from_ref(&effect), no_disturbance, 5));
        assert_eq!(entry.verdict, Verdict::Explained, "{effect}: {:?} {:?}", named(&entry), entry.reasons);
        assert_eq!(named(&entry), [effect["effect"].as_str().expect("a name")]);
        let worst = worst_sigma(&entry.effects[0].parameters, &effect);
        assert!(worst < 4.0, "{effect}: {worst} standard uncertainties");
    }
}

/// Turned by hand where the field is uneven: the sensors are not fitted away, and the calibration is written
/// where that is asked for.
#[test]
fn sensors_that_feel_nothing_are_no_answer() {
    let turns: Vec<Vector3<f64>> = (0..400)
        .map(|row| {
            let (a, z) = (2.4 * f64::from(row), 1.0 - 2.0 * (f64::from(row) + 0.5) / 400.0);
            Vector3::new((1.0 - z * z).sqrt() * a.cos(), (1.0 - z * z).sqrt() * a.sin(), z)
        })
        .collect();
    let uneven = |b: &Vector3<f64>| 52_000.0 * (1.0 + 0.06 * (3.0 * b.x).sin() * (2.0 * b.y).cos());
    let column = |axis: usize| turns.iter().map(|b| 1.1 * uneven(b) * b[axis] + 9000.0).collect::<Vec<f64>>();
    let document = json!({"fluxcal": 1, "recordings": [{"id": "hand", "procedure": "free_run", "columns": {
        "time_s": (0..400).map(|row| 0.15 * f64::from(row)).collect::<Vec<f64>>(), "reference_nt": vec![52_000.0; 400],
        "sensor_x_nt": column(0), "sensor_y_nt": column(1), "sensor_z_nt": column(2)}}]});
    let (entry, found) = diagnosed_with(parsed(&document), &Options { refit: true, ..Options::default() });
    let fit = entry.fit.expect("a fit");
    // The field is uneven by 6 % of 52 000 nT, rms some 1000 nT.
    assert!((300.0..2000.0).contains(&fit.rms_refitted_nt), "{fit:?}");
    let sensors = found.calibration.expect("a calibration").sensors.expect("sensors");
    // An ellipsoid by plain least squares of the lengths: the field's unevenness along x looks like an offset
    // of 1670 nT. Rms of 944 nT in 400 rows: each is uncertain by 944 √3/√400 = 82 nT.
    let ellipsoid = [-9849.0, -8182.0, -8165.0];
    for ((axis, sensor), expected) in sensors.iter().zip(ellipsoid) {
        let k = sensor.sensitivity_nt_per_nt.as_ref().expect("a sensitivity").value();
        assert!((k * 1.1 - 1.0).abs() < 0.05, "{axis}: {k}");
        let offset = sensor.offset_nt.as_ref().expect("an offset").value();
        assert!((offset - expected).abs() < 82.0, "{axis}: {offset} for {expected}");
    }
}
