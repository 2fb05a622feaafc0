//! Two magnetometers in recordings of their own.

use common::{Document, Verdict};
use diagnose::Options;
use serde_json::json;

use crate::pair::pair;

#[test]
fn a_pair_in_two_recordings_is_the_pair() {
    let (together, _) = pair();
    let mut apart: Document = together.clone();
    let mut reference = apart.recordings[0].clone();
    let mut test = apart.recordings.remove(0);
    reference.id = "reference".into();
    test.id = "test".into();
    reference.columns.retain(|name, _| !name.starts_with("test_"));
    test.columns.retain(|name, _| !name.starts_with("reference_"));
    apart.recordings = vec![reference, test];
    let rms = |document: &Document| {
        let found = diagnose::run(document.clone(), &Options::default()).expect("diagnosed");
        let recordings = found.recordings.len();
        let entry = found.diagnosis.expect("a diagnosis").remove(0);
        (entry.fit.expect("a fit").rms_refitted_nt, recordings)
    };
    let (known, found) = (rms(&together), rms(&apart));
    assert!((found.0 / known.0 - 1.0).abs() < 1e-9, "{found:?} {known:?}");
    assert_eq!(found.1, 2, "the document keeps its recordings");
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
fn field(t: f64, axis: usize) -> f64 {
    let wave = |k: u32| {
        let period_s = 40.0 * 1.18_f64.powi(k as i32);
        let phase = std::f64::consts::TAU * (0.618 * f64::from(k * k) + 0.377 * f64::from(k) * axis as f64);
        0.1 * period_s.powf(0.75) * (std::f64::consts::TAU * t / period_s + phase).sin()
    };
    [21_000.0, 900.0, 43_000.0][axis] + (0..24).map(wave).sum::<f64>()
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
            let read = time.iter().map(|t| field(t - late_s, axis) + noise_nt * stream.normal());
            columns[format!("{name}_{letter}_nt")] = json!(read.collect::<Vec<f64>>());
        }
        json!({"id": id, "procedure": "differential", "columns": columns})
    };
    let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let document = json!({"fluxcal": 1,
    "instrument": {"noise": {"white_rms_nt": NOISE_NT}},
    "calibration": {"differential": {"matrix": one, "offset_nt": {"x": 0.0, "y": 0.0, "z": 0.0}}},
    "recordings": [
        recording("hut", "reference", 3000, 0.4, 0.13, 0.0),
        recording("field", "test", 1000, 1.0, 30.5, late_s),
    ]});
    Document::parse(&document.to_string()).unwrap_or_else(|error| panic!("{error}"))
}

const NOISE_NT: f64 = 0.05;

#[test]
fn late_times_are_named_across_two_recordings_of_different_rates() {
    let late_s = 0.21;
    let entry = |document| {
        let found = diagnose::run(document, &Options::default()).expect("diagnosed");
        found.diagnosis.expect("a diagnosis").remove(0)
    };
    let found = entry(apart(late_s));
    let named: Vec<&str> = found.effects.iter().map(|effect| effect.effect.as_str()).collect();
    assert_eq!((found.verdict, named), (Verdict::Explained, vec!["clock_offset"]), "{}", found.answer);
    let offset = &found.effects[0].parameters["offset_s"];
    let std = offset.std().expect("an uncertainty");
    assert!((offset.value() - late_s).abs() < 3.0 * std && std < 0.02 * late_s, "{offset:?} for {late_s} s");
    let together = entry(apart(0.0));
    assert!(together.effects.is_empty(), "{}", together.answer);
}
