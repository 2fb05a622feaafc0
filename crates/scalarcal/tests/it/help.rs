//! The examples in the help texts run as they stand; completions and man pages are there.

use std::fs;

const SCALARCAL: &str = env!("CARGO_BIN_EXE_scalarcal");

#[test]
fn examples_run() {
    let folder = testkit::examples(SCALARCAL, &["stream", "merge"]);
    let result = fs::read_to_string(folder.path().join("result.json")).expect("a result");
    let result: serde_json::Value = serde_json::from_str(&result).expect("JSON");
    assert_eq!(result["calibration"]["scalar"]["rows"], 600);
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(SCALARCAL);
}
