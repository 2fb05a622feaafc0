//! Two magnetometers side by side: the fit is what linear least squares gives.

use common::Document;
use diagnose::Options;
use estimate::linear;
use faer::Mat;
use serde_json::{Value, json};

const ROWS: usize = 400;

/// The field of an observatory, which hardly changes: offsets and matrix trade with each other over long
/// distances.
fn field(row: usize) -> [f64; 3] {
    let t = row as f64 / ROWS as f64;
    [
        21_000.0 + 20.0 * (9.0 * t).sin(),
        900.0 + 15.0 * (23.0 * t).cos(),
        43_000.0 + 12.0 * (37.0 * t + 1.0).sin(),
    ]
}

/// A pair whose stated matrix and offsets are off, with columns that are no unit vectors; the readings of
/// each sensor.
pub fn pair() -> (Document, Vec<Vec<f64>>) {
    let matrix = [[0.9993, 0.0134, -0.0062], [-0.0126, 1.0023, 0.0044], [0.0070, -0.0042, 0.9996]];
    let mut stream = noise::Stream::new(3, "pair");
    let readings: Vec<Vec<f64>> = (0..3)
        .map(|sensor| {
            let read = |row: usize| {
                let felt: f64 = (0..3).map(|axis| matrix[axis][sensor] * field(row)[axis]).sum();
                felt + 30.0 + 0.05 * stream.normal()
            };
            (0..ROWS).map(read).collect()
        })
        .collect();
    let mut columns = json!({"time_s": (0..ROWS).map(|row| 60.0 * row as f64).collect::<Vec<_>>()});
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let reference: Vec<f64> = (0..ROWS).map(|row| field(row)[axis]).collect();
        columns[format!("reference_{name}_nt")] = json!(reference);
        columns[format!("test_{name}_nt")] = json!(readings[axis]);
    }
    let stated = matrix.map(|row| row.map(|value| value * 1.002));
    let document: Value = json!({
        "fluxcal": 1,
        "instrument": {"noise": {"white_rms_nt": 0.05}},
        "calibration": {"differential": {"matrix": stated, "offset_nt": {"x": 0.0, "y": 0.0, "z": 0.0}}},
        "recordings": [{"id": "pair", "procedure": "differential", "columns": columns}],
    });
    (Document::parse(&document.to_string()).unwrap_or_else(|error| panic!("{error}")), readings)
}

#[test]
fn the_fit_of_a_pair_is_that_of_linear_least_squares() {
    let (document, readings) = pair();
    let design = Mat::from_fn(ROWS, 4, |row, k| if k < 3 { field(row)[k] } else { 1.0 });
    let left =
        |reading: &Vec<f64>| linear::fit(design.as_ref(), reading, None).expect("fitted").sum_of_squares;
    let by_hand = (readings.iter().map(left).sum::<f64>() / (3 * ROWS) as f64).sqrt();
    let found = diagnose::run(document, &Options::default()).expect("diagnosed");
    let entry = found.diagnosis.expect("a diagnosis").remove(0);
    let fit = entry.fit.expect("a fit");
    assert!(
        (fit.rms_refitted_nt / by_hand - 1.0).abs() < 1e-5,
        "{} where {by_hand} is reached",
        fit.rms_refitted_nt
    );
    assert!(fit.rms_before_nt > 100.0 * by_hand);
}

/// The test instrument reads through a slower filter and has noise of its own; nothing of either is declared.
/// The field has a spectrum that falls, as at an observatory, and the calibration that came is nearly right.
#[test]
fn a_refit_of_a_pair_that_does_not_share_its_short_periods_does_not_raise_the_rms() {
    let mut stream = noise::Stream::new(1, "filters");
    let mut walk = [0.0; 3];
    let steps: Vec<[f64; 3]> = (0..ROWS)
        .map(|_| {
            walk = walk.map(|value| 0.98 * value + 2.0 * stream.normal());
            walk
        })
        .collect();
    let mut slow = [0.0; 3];
    let mut columns = json!({"time_s": (0..ROWS).map(|row| row as f64).collect::<Vec<_>>()});
    let mut test = [const { Vec::new() }; 3];
    for field in &steps {
        for axis in 0..3 {
            slow[axis] += 0.3 * (field[axis] - slow[axis]);
            test[axis].push([21_000.0, 900.0, 43_000.0][axis] + slow[axis] + 3.0 + 0.05 * stream.normal());
        }
    }
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let reference: Vec<f64> =
            steps.iter().map(|field| [21_000.0, 900.0, 43_000.0][axis] + field[axis]).collect();
        columns[format!("reference_{name}_nt")] = json!(reference);
        columns[format!("test_{name}_nt")] = json!(test[axis]);
    }
    let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let document = json!({"fluxcal": 1,
        "calibration": {"differential": {"matrix": one, "offset_nt": {"x": 3.0, "y": 3.0, "z": 3.0}}},
        "recordings": [{"id": "pair", "procedure": "differential", "columns": columns}]});
    let document = Document::parse(&document.to_string()).unwrap_or_else(|error| panic!("{error}"));
    let options = Options { refit: true, ..Options::default() };
    let found = diagnose::run(document, &options).expect("diagnosed");
    let fit = found.diagnosis.expect("a diagnosis").remove(0).fit.expect("a fit");
    assert!(fit.rms_refitted_nt <= fit.rms_before_nt, "{fit:?}");
    let left = |axis: usize| {
        let design = Mat::from_fn(ROWS, 4, |row, k| if k < 3 { steps[row][k] } else { 1.0 });
        linear::fit(design.as_ref(), &test[axis], None).expect("fitted").sum_of_squares
    };
    let by_hand = ((0..3).map(left).sum::<f64>() / (3 * ROWS) as f64).sqrt();
    assert!(fit.rms_refitted_nt < 1.001 * by_hand, "{} for {by_hand}", fit.rms_refitted_nt);
}

/// A load in amperes that is switched, and the document of a pair in which it moves x by 3 nT/A.
fn loaded() -> Document {
    let (mut document, _) = pair();
    let mut stream = noise::Stream::new(4, "load");
    let load: Vec<f64> = (0..ROWS).map(|row| f64::from(u8::from(row / 37 % 3 == 1))).collect();
    let columns = &mut document.recordings[0].columns;
    for (axis, nt_per_a) in [("x", 3.0), ("y", 0.0), ("z", 0.0)] {
        let test = columns.get_mut(&format!("test_{axis}_nt")).expect("readings");
        test.iter_mut().zip(&load).for_each(|(test, load)| *test += nt_per_a * load + 0.05 * stream.normal());
    }
    columns.insert("load_current_a".into(), load.into());
    document
}

#[test]
fn a_pair_is_held_against_a_simulation() {
    let (simulated, _) = pair();
    let options = Options { against: Some(simulated), ..Options::default() };
    let document = loaded();
    let recordings = document.recordings.clone();
    let found = diagnose::run(document, &options).expect("diagnosed");
    assert_eq!(found.recordings, recordings);
    let entry = found.diagnosis.expect("a diagnosis").remove(0);
    assert!(entry.answer.contains("load_current"), "{}", entry.answer);
    let fit = entry.fit.expect("a fit");
    assert!(fit.rms_before_nt > 10.0 * fit.rms_after_nt, "{fit:?}");
}

#[test]
fn a_simulation_that_is_the_recording_is_refused() {
    let options = Options { against: Some(loaded()), ..Options::default() };
    let error = diagnose::run(loaded(), &options).expect_err("a copy");
    assert!(error.to_string().contains("the readings of the simulation that --against names"), "{error}");
}

#[test]
fn what_is_left_out_without_effect_is_told() {
    let options = Options { without: vec![physics::Kind::StrayCurrent], ..Options::default() };
    let entry =
        diagnose::run(loaded(), &options).expect("diagnosed").diagnosis.expect("a diagnosis").remove(0);
    assert!(
        entry.reasons.iter().any(|reason| reason.contains("--without stray_current")),
        "{:?}",
        entry.reasons
    );
}

#[test]
fn a_pair_beside_other_recordings_has_an_answer_of_its_own() {
    let mut document =
        Document::parse(&testkit::read_fixture("diagnose/warm/input.json")).expect("a document");
    let alone = diagnose::run(document.clone(), &Options::default()).expect("diagnosed");
    document.recordings.extend(loaded().recordings);
    let both = diagnose::run(document, &Options::default()).expect("diagnosed");
    let (alone, both) = (alone.diagnosis.expect("a diagnosis"), both.diagnosis.expect("two"));
    assert_eq!(both.len(), 2);
    assert!(both[0].answer.contains("load_current"), "{}", both[0].answer);
    assert_eq!(both[1].answer, alone[0].answer);
}
