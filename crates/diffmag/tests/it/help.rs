//! The examples in the help texts run as they stand, and the README shows what is said.

use std::fs;

const DIFFMAG: &str = env!("CARGO_BIN_EXE_diffmag");

#[test]
fn examples_run() {
    let folder = testkit::examples(DIFFMAG, &["stream", "merge"]);
    let result = fs::read_to_string(folder.path().join("result.json")).expect("a result");
    let result: serde_json::Value = serde_json::from_str(&result).expect("JSON");
    assert_eq!(result["calibration"]["differential"]["matrix"].as_array().map(Vec::len), Some(3));
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(DIFFMAG);
}

#[test]
fn the_answer_that_the_readme_shows() {
    let readme = fs::read_to_string(testkit::fixture("../README.md")).expect("a page");
    let (_, shown) = readme.split_once("fixtures/diffmag/turned-pair/input.json").expect("the command");
    let (_, shown) = shown.split_once("```text\n").expect("what it says");
    let (shown, _) = shown.split_once("```").expect("the end");
    let said = testkit::run(DIFFMAG, &[], &testkit::read_fixture("diffmag/turned-pair/input.json")).stderr;
    for line in shown.lines().filter(|line| line.trim() != "…") {
        assert!(said.contains(line), "{line}\n{said}");
    }
}
