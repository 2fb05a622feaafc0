//! What a recording cannot tell apart is told so, and the next experiment decides.

use crate::bench;

use bench::{Scene, again, noise, simulated};
use common::{Document, Recording, Verdict};
use diagnose::Options;
use serde_json::{Value, json};

fn diagnosed(document: Document) -> (common::Diagnosis, String) {
    let found = diagnose::run(document, &Options::default()).expect("diagnosed");
    let words = diagnose::summary(&found);
    (found.diagnosis.expect("a diagnosis").remove(0), words)
}

/// A lag and a delay of milliseconds are the same at slow drives; ten times a second they are not.
#[test]
fn a_delay_and_a_lag_differ_only_at_fast_drives() {
    let effect = [json!({"effect": "delay", "sensor": "y", "parameters": {"delay_s": 0.004}})];
    let slow = simulated(Scene::Runs, &effect, &noise(), 5);
    let (entry, words) = diagnosed(slow.clone());
    println!("{words}");
    assert_eq!(entry.verdict, Verdict::Ambiguous, "{words}");
    let sets: Vec<&str> = entry.ambiguity.iter().flatten().map(String::as_str).collect();
    assert!(sets.contains(&"delay y") && sets.contains(&"loop_bandwidth y"), "{words}");
    assert!(entry.next_experiment.expect("a next experiment").contains("rate"));

    let mut both = slow;
    let mut fast = simulated(Scene::Quick, &effect, &noise(), 6).recordings.remove(0);
    fast.id = "fast".into();
    both.recordings.push(fast);
    let (entry, words) = diagnosed(both);
    println!("{words}");
    assert_eq!(entry.verdict, Verdict::Explained, "{words}");
    assert_eq!(entry.effects[0].effect, "delay", "{words}");
}

/// One run in which temperatures are as `moved` makes them, read with an effect.
fn run(scene: Scene, id: &str, effect: &Value, seed: u64, moved: fn(&mut Recording)) -> Document {
    let mut document = simulated(scene, &[], &json!({}), 1);
    document.recordings.truncate(1);
    document.recordings[0].id = id.into();
    moved(&mut document.recordings[0]);
    again(document, std::slice::from_ref(effect), &noise(), seed)
}

fn set(recording: &mut Recording, column: &str, value: impl Fn(f64) -> f64) {
    let time = recording.column("time_s").expect("times").to_vec();
    let values = &mut recording.columns.get_mut(column).expect("a column").0;
    values.iter_mut().zip(time).for_each(|(own, time)| *own = value(time));
}

/// Ambiguous between the truth and a rival; with the run that was asked for, explained by the truth.
fn decided(
    scene: Scene,
    effect: &Value,
    [rival, asked]: [&str; 2],
    first: fn(&mut Recording),
    then: fn(&mut Recording),
) {
    let truth = bench::target(effect);
    let mut document = run(scene, "first", effect, 31, first);
    let (entry, words) = diagnosed(document.clone());
    println!("{words}");
    assert_eq!(entry.verdict, Verdict::Ambiguous, "{words}");
    let sets: Vec<&str> = entry.ambiguity.iter().flatten().map(String::as_str).collect();
    assert!(sets.contains(&truth.as_str()) && sets.contains(&rival), "{words}");
    assert!(entry.next_experiment.expect("a next experiment").contains(asked), "{words}");

    document.recordings.extend(run(scene, "second", effect, 32, then).recordings);
    let (entry, words) = diagnosed(document);
    println!("{words}");
    assert_eq!(entry.verdict, Verdict::Explained, "{words}");
    assert_eq!(bench::target(&json!(entry.effects[0])), truth, "{words}");
}

/// Sensor and electronics in one box warm up together.
#[test]
fn two_thermometers_that_move_together() {
    let together = |recording: &mut Recording| {
        set(recording, "sensor_temperature_c", |t| 23.0 + 6.0 * (t / 400.0).sin());
        set(recording, "electronics_temperature_c", |t| 26.0 + 6.0 * (t / 400.0).sin());
    };
    let alone = |recording: &mut Recording| {
        set(recording, "sensor_temperature_c", |_| 23.0);
        set(recording, "electronics_temperature_c", |t| 26.0 + 6.0 * (t / 400.0).sin());
    };
    let effect = json!({"effect": "offset_electronics_temperature", "sensor": "y", "parameters": {"coefficient_nt_per_k": 0.2, "curvature_nt_per_k2": 0.0}});
    decided(Scene::Runs, &effect, ["offset_temperature y", "heat the electronics alone"], together, alone);
}

/// A temperature that only rises for three days says the same as time.
#[test]
fn a_temperature_that_only_rises_and_time() {
    let rises = |recording: &mut Recording| {
        for column in ["sensor_temperature_c", "electronics_temperature_c", "coil_temperature_c"] {
            set(recording, column, |_| 23.0);
        }
        set(recording, "sensor_temperature_c", |t| 18.0 + t / 28_800.0);
    };
    let back = |recording: &mut Recording| {
        for column in ["sensor_temperature_c", "electronics_temperature_c", "coil_temperature_c"] {
            set(recording, column, |_| 23.0);
        }
        set(recording, "sensor_temperature_c", |t| 18.0 + (t - 144_000.0).abs() / 14_400.0);
    };
    let effect = json!({"effect": "offset_temperature", "sensor": "x", "parameters": {"coefficient_nt_per_k": 0.3, "curvature_nt_per_k2": 0.0}});
    decided(Scene::Days, &effect, ["ageing x", "ramp the temperature up and down"], rises, back);
}
