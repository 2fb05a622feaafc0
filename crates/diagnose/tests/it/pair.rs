//! Two magnetometers, in one recording or in recordings of their own: the fit is what linear least squares gives.

use common::{Diagnosis, Document, Recording, Verdict};
use diagnose::Options;
use estimate::linear;
use faer::Mat;
use serde_json::{Value, json};
use std::f64::consts::TAU;

use crate::bench::{diagnosed, diagnosed_with, fixture, named, near, parsed};

const ROWS: usize = 400;
/// White noise of the test instrument, nT.
const NOISE_NT: f64 = 0.05;
const LEVEL_NT: [f64; 3] = [21_000.0, 900.0, 43_000.0];
const EQUAL: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The field of an observatory, which hardly changes: offsets and matrix trade over long distances.
fn field(row: usize) -> [f64; 3] {
    let t = row as f64 / ROWS as f64;
    [
        21_000.0 + 20.0 * (9.0 * t).sin(),
        900.0 + 15.0 * (23.0 * t).cos(),
        43_000.0 + 12.0 * (37.0 * t + 1.0).sin(),
    ]
}

/// A pair whose stated matrix and offsets are off, its columns no unit vectors; each sensor's readings.
fn pair() -> (Document, Vec<Vec<f64>>) {
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
    let recording = json!({"id": "pair", "procedure": "differential", "columns": columns});
    let mut document = stating(&json!(stated), 0.0, &json!([recording]));
    document["instrument"] = json!({"noise": {"white_rms_nt": NOISE_NT}});
    (parsed(&document), readings)
}

/// A document of recordings and of what is stated of a pair: a matrix, and one offset for all axes.
fn stating(matrix: &Value, offset_nt: f64, recordings: &Value) -> Value {
    let offset = json!({"x": offset_nt, "y": offset_nt, "z": offset_nt});
    json!({"fluxcal": 1, "calibration": {"differential": {"matrix": matrix, "offset_nt": offset}}, "recordings": recordings})
}

/// Rms of what linear least squares on a field and a level leave of three sensors.
fn by_hand(field: impl Fn(usize) -> [f64; 3], readings: &[Vec<f64>]) -> f64 {
    let design = Mat::from_fn(ROWS, 4, |row, k| if k < 3 { field(row)[k] } else { 1.0 });
    let left =
        |reading: &Vec<f64>| linear::fit(design.as_ref(), reading, None).expect("fitted").sum_of_squares;
    (readings.iter().map(left).sum::<f64>() / (3 * ROWS) as f64).sqrt()
}

#[test]
fn the_fit_of_a_pair_is_that_of_linear_least_squares() {
    let (document, readings) = pair();
    let least = by_hand(field, &readings);
    let fit = diagnosed(document).0.fit.expect("a fit");
    assert!((fit.rms_refitted_nt / least - 1.0).abs() < 1e-5, "{fit:?} where {least} is reached");
    assert!(fit.rms_before_nt > 100.0 * least);
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
    let mut test = vec![Vec::new(); 3];
    for field in &steps {
        for axis in 0..3 {
            slow[axis] += 0.3 * (field[axis] - slow[axis]);
            test[axis].push(LEVEL_NT[axis] + slow[axis] + 3.0 + NOISE_NT * stream.normal());
        }
    }
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let reference: Vec<f64> = steps.iter().map(|field| LEVEL_NT[axis] + field[axis]).collect();
        columns[format!("reference_{name}_nt")] = json!(reference);
        columns[format!("test_{name}_nt")] = json!(test[axis]);
    }
    let recording = json!({"id": "pair", "procedure": "differential", "columns": columns});
    let document = parsed(&stating(&json!(EQUAL), 3.0, &json!([recording])));
    let (entry, _) = diagnosed_with(document, &Options { refit: true, ..Options::default() });
    let (fit, least) = (entry.fit.expect("a fit"), by_hand(|row| steps[row], &test));
    assert!(fit.rms_refitted_nt <= fit.rms_before_nt, "{fit:?}");
    assert!(fit.rms_refitted_nt < 1.001 * least, "{fit:?} for {least}");
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
    let (entry, found) = diagnosed_with(document, &options);
    assert_eq!(found.recordings, recordings);
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
    let Diagnosis { reasons, .. } = diagnosed_with(loaded(), &options).0;
    assert!(reasons.iter().any(|reason| reason.contains("--without stray_current")), "{reasons:?}");
}

#[test]
fn a_pair_beside_other_recordings_has_an_answer_of_its_own() {
    let mut document = fixture("diagnose/warm/input.json");
    let (alone, _) = diagnosed(document.clone());
    document.recordings.extend(loaded().recordings);
    let both = diagnosed(document).1.diagnosis.expect("two");
    assert_eq!(both.len(), 2);
    assert!(both[0].answer.contains("load_current"), "{}", both[0].answer);
    assert_eq!(both[1].answer, alone.answer);
}

#[test]
fn a_pair_in_two_recordings_is_the_pair() {
    let (together, _) = pair();
    let mut apart = together.clone();
    apart.recordings = ["reference", "test"]
        .map(|id| Recording { id: id.into(), ..together.recordings[0].clone() })
        .to_vec();
    apart.recordings[0].columns.retain(|name, _| !name.starts_with("test_"));
    apart.recordings[1].columns.retain(|name, _| !name.starts_with("reference_"));
    let rms = |document: &Document| {
        let (entry, found) = diagnosed(document.clone());
        assert_eq!(found.recordings.len(), document.recordings.len(), "the document keeps its recordings");
        entry.fit.expect("a fit").rms_refitted_nt
    };
    let (known, found) = (rms(&together), rms(&apart));
    assert!((found / known - 1.0).abs() < 1e-9, "{found} {known}");
    let mut never = apart;
    if let Some(time) = never.recordings[1].columns.get_mut("time_s") {
        time.iter_mut().for_each(|t| *t += 1e6);
    }
    let error = diagnose::run(never, &Options::default()).expect_err("never together").to_string();
    assert!(error.contains("recordings that overlap in time"), "{error}");
}

/// The field at a time: periods from 40 s to half an hour, so that a sample is little of any of them (the
/// catalogue's delays take slopes from one sample to the next, which are 7 % too small at nine samples a
/// period), of unlike phases in the three axes.
fn field_at(t: f64, axis: usize) -> f64 {
    let wave = |k: u32| {
        let period_s = 40.0 * 1.18_f64.powi(k as i32);
        let phase = TAU * (0.618 * f64::from(k * k) + 0.377 * f64::from(k) * axis as f64);
        0.1 * period_s.powf(0.75) * (TAU * t / period_s + phase).sin()
    };
    LEVEL_NT[axis] + (0..24).map(wave).sum::<f64>()
}

/// Two instruments with rates and times of their own; the test instrument's times are late. The reference is
/// quiet: the catalogue takes what it reads as the field.
fn apart(late_s: f64) -> Document {
    let mut stream = noise::Stream::new(7, "apart");
    let mut recording = |id: &str, name: &str, rows: usize, step_s: f64, from_s: f64, late_s: f64| {
        let time: Vec<f64> = (0..rows).map(|row| from_s + step_s * row as f64).collect();
        let noise_nt = if name == "reference" { 0.1 * NOISE_NT } else { NOISE_NT };
        let mut columns = json!({"time_s": time});
        for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
            let read = time.iter().map(|t| field_at(t - late_s, axis) + noise_nt * stream.normal());
            columns[format!("{name}_{letter}_nt")] = json!(read.collect::<Vec<f64>>());
        }
        json!({"id": id, "procedure": "differential", "columns": columns})
    };
    let recordings = [
        recording("hut", "reference", 3000, 0.4, 0.13, 0.0),
        recording("field", "test", 1000, 1.0, 30.5, late_s),
    ];
    let mut document = stating(&json!(EQUAL), 0.0, &json!(recordings));
    document["instrument"] = json!({"noise": {"white_rms_nt": NOISE_NT}});
    parsed(&document)
}

#[test]
fn late_times_are_named_across_two_recordings_of_different_rates() {
    let late_s = 0.21;
    let (found, _) = diagnosed(apart(late_s));
    assert_eq!(
        (found.verdict, named(&found)),
        (Verdict::Explained, vec!["clock_offset"]),
        "{}",
        found.answer
    );
    near(&found.effects[0].parameters["offset_s"], late_s, 3.0, 0.02 * late_s);
    let (together, _) = diagnosed(apart(0.0));
    assert!(together.effects.is_empty(), "{}", together.answer);
}

/// In orbit the field turns: noise of the reference and curves of the field are no effect, a scale factor that follows the
/// temperature and a response that is not straight have their names and sizes.
#[test]
fn where_the_field_turns_scale_factors_and_curves_are_named() {
    for (change, expected) in [
        ("nothing", vec![]),
        ("warm", vec![("sensitivity_temperature", "coefficient_ppm_per_k", 30.0)]),
        ("curved", vec![("quadratic_nonlinearity", "departure_nt", 20.0)]),
    ] {
        let mut stream = noise::Stream::new(7, change);
        let mut columns = json!({});
        let time: Vec<f64> = (0..6000).map(f64::from).collect();
        let warm: Vec<f64> = time.iter().map(|t| 20.0 + 12.0 * (t / 880.0 + 0.4).sin()).collect();
        for (axis, name) in ["x", "y", "z"].iter().enumerate() {
            let field = |t: f64| match axis {
                0 => 25e3 * (t / 900.0).cos() + 3e3 * (t / 140.0).sin(),
                1 => -18e3 * (t / 1100.0).sin(),
                _ => 30e3 * (t / 1500.0 + 1.0).cos(),
            };
            let more = |field: f64, kelvin: f64| match change {
                "warm" if axis == 0 => 30e-6 * kelvin * field,
                "curved" if axis == 0 => 20.0 * (field / 5e4).powi(2),
                _ => 0.0,
            };
            let reference: Vec<f64> = time.iter().map(|t| field(*t) + 0.3 * stream.normal()).collect();
            let of = |(t, warm): (&f64, &f64)| {
                let own = 1.001 * field(*t) + 50.0;
                own + more(own, warm - 20.0) + stream.normal()
            };
            let test: Vec<f64> = time.iter().zip(&warm).map(of).collect();
            columns[format!("reference_{name}_nt")] = json!(reference);
            columns[format!("test_{name}_nt")] = json!(test);
        }
        (columns["time_s"], columns["test_temperature_c"]) = (json!(time), json!(warm));
        let recording = json!({"id": "orbit", "procedure": "differential", "columns": columns});
        let entry = diagnosed(parsed(&json!({"fluxcal": 1, "recordings": [recording]}))).0;
        let verdict = if expected.is_empty() { Verdict::Agrees } else { Verdict::Explained };
        assert_eq!((entry.verdict, entry.effects.len()), (verdict, expected.len()), "{}", entry.answer);
        let fit = entry.fit.as_ref().expect("a fit");
        assert!(fit.held_out_after_nt < 1.02 * fit.rms_after_nt, "{fit:?}");
        for (effect, (name, parameter, truth)) in entry.effects.iter().zip(expected) {
            assert_eq!((effect.effect.as_str(), effect.sensor), (name, Some(common::Axis::X)));
            let found = &effect.parameters[parameter];
            let off = (found.value() - truth) / found.std().expect("an uncertainty");
            assert!(off.abs() < 3.0, "{name}: {found}");
        }
    }
}
