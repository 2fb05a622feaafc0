//! Every document of `fixtures/bad/diagnose` brings its message, its exit code, and nothing on standard
//! output.

use serde_json::{Value, json};

const DIAGNOSE: &str = env!("CARGO_BIN_EXE_diagnose");

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/diagnose", DIAGNOSE) >= 14);
}

/// Runs with arguments on a good document: exit code, what was said, and nothing on standard output.
fn refused(arguments: &[&str]) -> String {
    let run = testkit::run_in(DIAGNOSE, &testkit::fixture("diagnose"), arguments);
    assert!(run.stdout.is_empty() && run.code != 0);
    run.stderr
}

#[test]
fn requests_that_make_no_sense() {
    let level = refused(&["--level", "1.5", "warm/input.json"]);
    assert!(level.contains("a level of 1.5; expected a probability"), "{level}");
    let missing = refused(&["--against", "nowhere.json", "warm/input.json"]);
    assert!(missing.contains("nowhere.json"), "{missing}");
    let short = refused(&["--against", "../bad/diagnose/two-rows.json", "warm/input.json"]);
    assert!(short.contains("found 120 rows where the simulation of \"run-1\" has 2"), "{short}");
    let other = refused(&["--against", "../coilcal/uneven/input.json", "warm/input.json"]);
    let effect = refused(&["--without", "delays", "warm/input.json"]);
    assert!(
        effect.contains("there is no effect \"delays\"; expected one of quadratic_nonlinearity"),
        "{effect}"
    );
    assert!(other.contains("the simulation has none of the document's recordings"), "{other}");
}

/// What cannot be used is told, and the rest is diagnosed.
#[test]
fn what_is_left_aside_is_told() {
    let mut document: Value =
        serde_json::from_str(&testkit::read_fixture("diagnose/warm/input.json")).expect("JSON");
    document["model"] = json!({"effects": [{"effect": "coil_temperature", "coil": "x", "parameters": {"coefficient_ppm_per_k": 1.0}}]});
    document["calibration"]["reference_conditions"]["coil_temperature_c"] = json!(21.0);
    let recording = &mut document["recordings"][0];
    recording["columns"].as_object_mut().expect("columns").remove("coil_temperature_c");
    recording["columns"]["time_s"][3] = Value::Null;
    document["recordings"].as_array_mut().expect("recordings").truncate(1);
    let run = testkit::run(DIAGNOSE, &[], &document.to_string());
    assert_eq!(run.code, 0, "{}", run.stderr);
    for told in
        ["note: coil_temperature x of model.effects acts in no recording", "note: the times of \"run-1\""]
    {
        assert!(run.stderr.contains(told), "{}", run.stderr);
    }
}
