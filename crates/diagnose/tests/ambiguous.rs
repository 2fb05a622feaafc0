//! What a recording cannot tell apart is told so, and the next experiment decides.

mod bench;

use bench::{Scene, noise, simulated};
use common::{Document, Verdict};
use diagnose::Options;
use serde_json::json;

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
