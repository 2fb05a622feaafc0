//! What a recording cannot tell apart is told so, and the next experiment decides.

use common::{Document, Recording, Verdict};
use serde_json::{Value, json};
use simulate::Plan;

use crate::bench::{Scene, again, diagnosed, noise, simulated, target};

/// Ambiguous between truth and rival; with the recording that is asked for, explained by the truth.
fn decided(document: Document, effect: &Value, rival: &str) {
    let truth = target(effect);
    let (entry, _) = diagnosed(document.clone());
    assert_eq!(entry.verdict, Verdict::Ambiguous, "{}", entry.answer);
    let sets: Vec<&str> = entry.ambiguity.iter().flatten().map(String::as_str).collect();
    assert!(sets.contains(&truth.as_str()) && sets.contains(&rival), "{}", entry.answer);
    let best = &entry.experiments[0];
    println!("{} ({:.0})", best.what, best.log_odds);
    assert!(best.between.contains(&truth) && entry.next_experiment.as_ref() == Some(&best.what));

    let mut plan = best.plan.clone().expect("a plan");
    plan["seed"] = json!(32);
    plan["truth"] = json!({"model": {"effects": [effect]}});
    let plan = Plan::parse(&plan.to_string()).unwrap_or_else(|error| panic!("{error}"));
    let made = simulate::campaign(&plan).unwrap_or_else(|error| panic!("{error}")).document;
    let mut both = document;
    both.recordings.extend(made.recordings);
    let (entry, _) = diagnosed(both);
    assert_eq!(entry.verdict, Verdict::Explained, "{}", entry.answer);
    assert_eq!(target(&json!(entry.effects[0])), truth, "{}", entry.answer);
}

/// A lag and a delay of milliseconds are the same at slow drives; at fast ones they are not.
#[test]
fn a_delay_and_a_lag_differ_only_at_fast_drives() {
    let effect = json!({"effect": "delay", "sensor": "y", "parameters": {"delay_s": 0.004}});
    let document = simulated(Scene::Runs, std::slice::from_ref(&effect), &noise(), 5);
    decided(document, &effect, "loop_bandwidth y");
}

/// One run in which temperatures are as `moved` makes them, read with an effect.
fn run(scene: Scene, effect: &Value, moved: fn(&mut Recording)) -> Document {
    let mut document = simulated(scene, &[], &json!({}), 1);
    document.recordings.truncate(1);
    moved(&mut document.recordings[0]);
    again(document, std::slice::from_ref(effect), &noise(), 31)
}

fn set(recording: &mut Recording, column: &str, value: impl Fn(f64) -> f64) {
    let time = recording.column("time_s").expect("times").to_vec();
    let values = &mut recording.columns.get_mut(column).expect("a column");
    values.iter_mut().zip(time).for_each(|(own, time)| *own = value(time));
}

/// Sensor and electronics in one box warm up together.
#[test]
fn two_thermometers_that_move_together() {
    let together = |recording: &mut Recording| {
        set(recording, "sensor_temperature_c", |t| 23.0 + 6.0 * (t / 400.0).sin());
        set(recording, "electronics_temperature_c", |t| 26.0 + 6.0 * (t / 400.0).sin());
    };
    let effect = json!({"effect": "offset_electronics_temperature", "sensor": "y", "parameters": {"coefficient_nt_per_k": 0.2, "curvature_nt_per_k2": 0.0}});
    decided(run(Scene::Runs, &effect, together), &effect, "offset_temperature y");
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
    let effect = json!({"effect": "offset_temperature", "sensor": "x", "parameters": {"coefficient_nt_per_k": 0.3, "curvature_nt_per_k2": 0.0}});
    decided(run(Scene::Days, &effect, rises), &effect, "ageing x");
}
