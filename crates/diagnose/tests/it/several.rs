//! Two and three effects at once; the document that diagnose wrote meets the recording, and a fresh one.

use common::{Axis, Document, Verdict};
use serde_json::{Value, json};

use crate::bench::{Scene, adopted, again, diagnosed, near, noise, simulated, target};

fn sets() -> Vec<Vec<Value>> {
    let warm = json!({"effect": "offset_temperature_lag", "sensor": "x", "parameters": {"coefficient_nt_per_k": 0.3, "lag_s": 300.0}});
    let bent =
        json!({"effect": "quadratic_nonlinearity", "sensor": "y", "parameters": {"departure_nt": 3.0}});
    let eddy = json!({"effect": "eddy_currents", "coil": "y", "parameters": {"share_ppm": 200.0, "time_constant_s": 60.0}});
    let across = json!({"effect": "cross_field", "sensor": "z", "parameters": {"first_nt": 4.0, "second_nt": -2.0, "mixed_nt": 1.0}});
    let clock = json!({"effect": "clock_offset", "parameters": {"offset_s": 0.02}});
    let step =
        json!({"effect": "reading_step", "sensor": "z", "parameters": {"height_nt": 8.0, "time_s": 2700.0}});
    vec![
        vec![warm.clone(), bent.clone()],
        vec![eddy.clone(), across.clone()],
        vec![clock.clone(), step.clone()],
        vec![warm.clone(), step.clone()],
        vec![bent, across, warm],
        vec![eddy, clock, step],
    ]
}

#[test]
fn several_effects_are_all_named() {
    let mut wrong = Vec::new();
    for (number, effects) in testkit::some(sets().iter().enumerate().collect(), 3) {
        let (entry, found) = diagnosed(simulated(Scene::Runs, effects, &noise(), 300 + number as u64));
        let (names, mut truth) = (adopted(&found), effects.iter().map(target).collect::<Vec<_>>());
        truth.sort();
        println!("{truth:?} -> {} {names:?} {:?}", entry.verdict.word(), entry.ambiguity);
        if entry.verdict != Verdict::Explained || names != truth {
            wrong.push(format!("{truth:?}: {names:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// What a leak kept of the time before a recording, which nobody recorded, is no other effect.
#[test]
fn a_recording_that_begins_in_the_midst_of_a_leak() {
    let leak = json!({"effect": "nulling_leakage", "parameters": {"north_ppm": 30000.0, "east_ppm": 20000.0,
        "down_ppm": 40000.0, "lag_s": 3000.0}});
    let mut document = simulated(Scene::Site, &[leak], &noise(), 5);
    for column in document.recordings[0].columns.values_mut() {
        column.drain(..150);
    }
    let (entry, found) = diagnosed(document);
    assert_eq!(adopted(&found), ["nulling_leakage"], "{}", entry.answer);
    let fit = entry.fit.expect("a fit");
    assert!(fit.held_out_after_nt < 1.05 * fit.noise_floor_nt, "{}", entry.answer);
}

/// What diagnose wrote agrees with the recording that it came from, and predicts a fresh one of the same
/// instrument as well as the first was fitted.
#[test]
fn the_loop_closes() {
    let effects = &sets()[0];
    let (entry, found) = diagnosed(simulated(Scene::Runs, effects, &noise(), 41));
    assert_eq!(entry.verdict, Verdict::Explained);
    let mut fresh = simulated(Scene::Runs, effects, &noise(), 42);
    (fresh.calibration, fresh.model) = (found.calibration.clone(), found.model.clone());
    for (document, within) in [(found, 0.05), (fresh, 0.08)] {
        let (entry, _) = diagnosed(document);
        assert_eq!(entry.verdict, Verdict::Agrees, "{}", entry.answer);
        let fit = entry.fit.expect("a fit");
        assert!((fit.rms_before_nt / fit.noise_floor_nt - 1.0).abs() < within, "{}", fit.rms_before_nt);
    }
}

/// A knock moves all sensors at once: one finding.
#[test]
fn a_step_in_all_sensors_is_told_once() {
    let step = |sensor: &str, height: f64| json!({"effect": "reading_step", "sensor": sensor, "parameters": {"height_nt": height, "time_s": 2700.0}});
    let effects = [step("x", 8.0), step("y", -5.0), step("z", 3.0)];
    let (entry, found) = diagnosed(simulated(Scene::Runs, &effects, &noise(), 51));
    assert_eq!(entry.verdict, Verdict::Explained, "{}", entry.answer);
    let [knock] = &entry.effects[..] else { panic!("{}", entry.answer) };
    assert_eq!((knock.effect.as_str(), knock.sensor), ("reading_step", None));
    for (name, height) in [("x_height_nt", 8.0), ("y_height_nt", -5.0), ("z_height_nt", 3.0)] {
        let found = knock.parameters[name].value();
        assert!((found - height).abs() < 0.3, "{name} {found}");
    }
    assert_eq!(adopted(&found), ["reading_step x", "reading_step y", "reading_step z"]);
}

/// A range that is changed between two recordings is a step at the first row of the second.
#[test]
fn a_level_that_changes_between_recordings_is_a_step() {
    let step =
        json!({"effect": "reading_step", "sensor": "z", "parameters": {"height_nt": 8.0, "time_s": 2200.0}});
    let (entry, _) = diagnosed(simulated(Scene::Cube, &[step], &noise(), 52));
    assert_eq!(entry.verdict, Verdict::Explained, "{}", entry.answer);
    let [step] = &entry.effects[..] else { panic!("{}", entry.answer) };
    assert_eq!((step.effect.as_str(), step.sensor), ("reading_step", Some(Axis::Z)), "{}", entry.answer);
    assert!((step.parameters["height_nt"].value() - 8.0).abs() < 0.3, "{}", entry.answer);
}

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

/// 17 280 readings, which are searched on some of the rows first. What was screened out is told as what could have shown.
#[test]
fn effects_are_named_by_all_rows() {
    let effects = [
        json!({"effect": "offset_temperature_lag", "sensor": "x", "parameters": {"coefficient_nt_per_k": 0.02, "lag_s": 300.0}}),
        json!({"effect": "eddy_currents", "coil": "y", "parameters": {"share_ppm": 40.0, "time_constant_s": 60.0}}),
    ];
    let document = longer(simulated(Scene::Runs, &[], &noise(), 1), 12);
    let (entry, found) = diagnosed(again(document, &effects, &noise(), 9));
    assert_eq!(entry.verdict, Verdict::Explained, "{:?}", entry.reasons);
    assert_eq!(adopted(&found), ["eddy_currents y", "offset_temperature_lag x"]);
    for (effect, (name, truth)) in effects.iter().zip([("coefficient_nt_per_k", 0.02), ("share_ppm", 40.0)]) {
        let mut listed = found.model.iter().flat_map(|model| &model.effects);
        let own = listed.find(|own| own.effect == effect["effect"]).expect("listed");
        near(&own.parameters[name], truth, 3.5, f64::INFINITY);
    }
    for effect in ["hysteresis", "clipping", "clock_offset"] {
        assert!(entry.detectable.iter().any(|one| one.effect == effect), "{effect}");
    }
}
