//! A campaign that is searched on some of its rows first.

use crate::bench;

use bench::{Scene, again, noise, simulated, target};
use common::{Document, Verdict};
use diagnose::Options;
use serde_json::json;

/// A document with every recording so many times as long, one after the other.
fn longer(mut document: Document, times: usize) -> Document {
    for (run, recording) in document.recordings.iter_mut().enumerate() {
        let rows = recording.rows();
        for (name, column) in &mut recording.columns {
            let length = if name == "time_s" { 10.0 * rows as f64 } else { 0.0 };
            let at = |row: usize| column[row % rows] + length * (row / rows + run * times) as f64;
            *column = (0..times * rows).map(at).collect();
        }
    }
    document
}

/// 17 280 readings. What was screened out is told as what could have shown.
#[test]
fn effects_are_named_by_all_rows() {
    let effects = [
        json!({"effect": "offset_temperature_lag", "sensor": "x", "parameters": {"coefficient_nt_per_k": 0.02, "lag_s": 300.0}}),
        json!({"effect": "eddy_currents", "coil": "y", "parameters": {"share_ppm": 40.0, "time_constant_s": 60.0}}),
    ];
    let document = longer(simulated(Scene::Runs, &[], &noise(), 1), 12);
    let found =
        diagnose::run(again(document, &effects, &noise(), 9), &Options::default()).expect("diagnosed");
    let entry = &found.diagnosis.as_ref().expect("a diagnosis")[0];
    assert_eq!(entry.verdict, Verdict::Explained, "{:?}", entry.reasons);
    let listed: Vec<_> = found.model.iter().flat_map(|model| &model.effects).collect();
    let mut names: Vec<String> = listed.iter().map(|effect| target(&json!(effect))).collect();
    names.sort();
    assert_eq!(names, ["eddy_currents y", "offset_temperature_lag x"]);
    for (effect, truth) in effects.iter().zip([("coefficient_nt_per_k", 0.02), ("share_ppm", 40.0)]) {
        let own = listed.iter().find(|own| own.effect == effect["effect"]).expect("listed");
        let quantity = &own.parameters[truth.0];
        let std = quantity.std().expect("an uncertainty");
        assert!((quantity.value() - truth.1).abs() < 3.5 * std, "{quantity:?}");
    }
    for effect in ["hysteresis", "clipping", "clock_offset"] {
        assert!(entry.detectable.iter().any(|one| one.effect == effect), "{effect}");
    }
}
