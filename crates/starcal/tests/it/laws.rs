//! Pieces of a flight, and turns of its frames.

use common::{AttitudeFrame, Document, Quantity, Recording};
use nalgebra::{Quaternion, Rotation3, UnitQuaternion};
use partial::{Series, Take};
use starcal::{Columns, Partial, answer, run};
use std::ops::Range;

fn columns(frame: AttitudeFrame) -> Columns {
    Columns { frame, ..Columns::default() }
}

fn made(seed: u64) -> Document {
    let plan = simulate::FlightPlan { seed, days: 1.0, step_s: 200.0, ..simulate::FlightPlan::default() };
    simulate::flight(&plan).expect("a flight").document
}

fn empty() -> Document {
    Document { fluxcal: 1, ..Document::default() }
}

/// k and O.
fn constants(document: &Document) -> Vec<Quantity> {
    let sensors = document.calibration.as_ref().and_then(|found| found.sensors.as_ref()).expect("sensors");
    let of = |one: &common::SensorCalibration| [one.sensitivity_nt_per_nt.clone(), one.offset_nt.clone()];
    sensors.iter().flat_map(|(_, one)| of(one)).map(|one| one.expect("a value")).collect()
}

/// k, O and μ.
fn sensors(document: &Document) -> Vec<f64> {
    let axes = document.calibration.as_ref().and_then(|found| found.axes.as_ref());
    let matrix = axes.and_then(|axes| axes.sensors.as_ref()?.matrix).expect("directions");
    constants(document).iter().map(Quantity::value).chain(matrix.into_iter().flatten()).collect()
}

fn near(one: &[f64], other: &[f64], within: f64) -> Result<(), String> {
    let worst = one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    if worst < within { Ok(()) } else { Err(format!("{one:?} {other:?}")) }
}

fn piece(recording: &Recording, rows: Range<usize>) -> Partial {
    let there: Vec<String> = recording.columns.keys().cloned().collect();
    let (names, mut taking) = columns(AttitudeFrame::Icrf).begin(&there).expect("columns");
    let start_s = recording.start().expect("a start").unix_s;
    let of = |name: &String| -> Vec<f64> {
        let shift = if name == "time_s" { start_s } else { 0.0 };
        recording.column(name).expect("a column")[rows.clone()].iter().map(|value| value + shift).collect()
    };
    let values: Vec<Vec<f64>> = names.iter().map(of).collect();
    let values: Vec<&[f64]> = values.iter().map(Vec::as_slice).collect();
    taking.push(&values).and_then(|()| taking.finish()).expect("rows")
}

/// In any order and grouping pieces give the calibration of one pass.
#[test]
fn pieces_merge() {
    let same = |one: &Partial, other: &Partial| {
        let [one, other] = [one, other].map(|one| sensors(&answer(one, empty()).expect("a calibration")));
        near(&one, &other, 1e-6)
    };
    let piece = |seed: u64, rows: Range<usize>| piece(&made(seed % 3).recordings[0], rows);
    testkit::partials_merge(8, 432, piece, same);
}

/// The camera in another mount: sensors stay as they are, and the head turns by as much.
#[test]
fn a_turned_camera_turns_its_head_alone() {
    let document = made(4);
    let turn = UnitQuaternion::from_euler_angles(0.4, -0.2, 1.0);
    let mut turned = document.clone();
    let columns_of = &mut turned.recordings[0].columns;
    let parts = ["w", "x", "y", "z"].map(|part| format!("camera_1_{part}"));
    let mut values = parts.each_ref().map(|part| columns_of[part].to_vec());
    for row in 0..values[0].len() {
        let [w, x, y, z] = [0, 1, 2, 3].map(|k| values[k][row]);
        let q = turn.into_inner() * Quaternion::new(w, x, y, z);
        for (column, value) in values.iter_mut().zip([q.w, q.i, q.j, q.k]) {
            column[row] = value;
        }
    }
    for (part, column) in parts.iter().zip(values) {
        columns_of.insert(part.clone(), column.into());
    }
    let [one, other] =
        [document, turned].map(|one| run(one, &columns(AttitudeFrame::Geo)).expect("a calibration"));
    // The boresight has other noise then, and weights differ: by less than a standard uncertainty.
    for (place, (a, b)) in constants(&one).iter().zip(constants(&other)).enumerate() {
        let std = a.std().expect("an uncertainty");
        assert!((a.value() - b.value()).abs() < std, "{place}: {a} {b} ± {std}");
    }
    let head = |document: &Document| {
        let calibration = document.calibration.as_ref().expect("a calibration");
        let rows = calibration.flight.as_ref().expect("a flight").cameras[0].rotation;
        Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_fn(|i, j| rows[i][j]))
    };
    let between = head(&other) * head(&one).inverse() * turn.to_rotation_matrix().inverse();
    assert!(between.angle() < 1e-4, "{}", between.angle());
}

/// Windows that become wider while rows are taken keep each row where its time is.
#[test]
fn windows_of_a_long_flight_are_those_of_its_times() {
    let plan = simulate::FlightPlan { days: 20.0, step_s: 1500.0, ..simulate::FlightPlan::default() };
    let recording = &simulate::flight(&plan).expect("a flight").document.recordings[0];
    let line = partial::to_line(&piece(recording, 0..recording.rows()));
    let value: serde_json::Value = serde_json::from_str(&line).expect("JSON");
    let width = 2f64.powi(value["statistics"]["exponent"].as_i64().expect("an exponent") as i32);
    let windows = value["statistics"]["windows"].as_object().expect("windows");
    let start_s = recording.start().expect("a start").unix_s;
    assert!(width > 8192.0 && windows.len() > 32, "{width} {}", windows.len());
    for at in windows.keys() {
        let from_s = at.parse::<f64>().expect("a number") * width - start_s;
        assert!(from_s > -width && from_s < 20.0 * 86_400.0, "{at}: {from_s} s");
    }
}
