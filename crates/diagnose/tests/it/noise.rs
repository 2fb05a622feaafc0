//! Noise that is declared wrongly, or not at all, takes no name away.

use crate::bench;

use bench::{NOISE_NT, Scene, simulated};
use common::{Document, Verdict};
use diagnose::Options;
use serde_json::{Value, json};

fn names(mut document: Document, noise: &Value) -> Vec<String> {
    document.instrument.get_or_insert_default().noise = serde_json::from_value(noise.clone()).expect("noise");
    let found = diagnose::run(document, &Options::default()).expect("diagnosed");
    let entry = found.diagnosis.expect("a diagnosis").remove(0);
    assert_eq!(entry.verdict, Verdict::Explained, "{:?}", entry.reasons);
    let effects = serde_json::to_value(entry.effects).expect("effects");
    let effects = effects.as_array().expect("a list").iter();
    effects.filter_map(|effect| effect["effect"].as_str().map(str::to_string)).collect()
}

/// What a declaration is off by counts neither as a difference nor as something that names have to explain.
#[test]
fn noise_that_is_declared_a_tenth_wrong_takes_no_name_away() {
    let bent = json!({"effect": "cubic_nonlinearity", "sensor": "z", "parameters": {"departure_nt": 4.0}});
    let document = simulated(Scene::Runs, &[bent], &json!({"white_rms_nt": NOISE_NT}), 31);
    for factor in [1.0 / 1.1, 1.1] {
        let noise = json!({"white_rms_nt": factor * NOISE_NT});
        assert_eq!(names(document.clone(), &noise), ["cubic_nonlinearity"], "{factor}");
    }
}

/// A slow effect passes for slow noise where noise is estimated from what it left.
#[test]
fn a_slow_effect_is_not_taken_for_noise_that_nobody_declared() {
    let warm = json!({"effect": "warm_up", "sensor": "y", "parameters": {"amplitude_nt": 12.0, "time_constant_s": 9000.0}});
    let document = simulated(Scene::Pair, &[warm], &json!({"white_rms_nt": NOISE_NT}), 32);
    assert_eq!(names(document, &Value::Null), ["warm_up"]);
}
