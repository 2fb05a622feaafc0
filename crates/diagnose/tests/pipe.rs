//! The program as its users call it.

use common::Document;
use std::process::Command;

fn diagnose(arguments: &[&str], threads: &str) -> (Vec<u8>, String, Option<i32>) {
    let output = Command::new(env!("CARGO_BIN_EXE_diagnose"))
        .args(arguments)
        .env("RAYON_NUM_THREADS", threads)
        .current_dir(testkit::fixture(".."))
        .output()
        .expect("run");
    (output.stdout, String::from_utf8_lossy(&output.stderr).into_owned(), output.status.code())
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let one = diagnose(&["fixtures/diagnose/warm/input.json"], "1");
    let four = diagnose(&["fixtures/diagnose/warm/input.json"], "4");
    assert!(one.2 == Some(0) && one == four);
    assert!(one.1.contains("offset_temperature_lag of sensor x"), "{}", one.1);
    // README and page show what is said.
    for page in ["../README.md", "../docs/diagnose.md"] {
        let page = std::fs::read_to_string(testkit::fixture(page)).expect("a page");
        let (_, shown) = page.split_once("diagnose: explained\n").expect("what it says");
        for line in shown.lines().take(3) {
            assert!(one.1.contains(line.trim()), "{line}\n{}", one.1);
        }
    }
}

#[test]
fn a_document_without_readings_is_refused_with_nothing_on_stdout() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("empty.json");
    std::fs::write(&file, r#"{"fluxcal": 1, "recordings": []}"#).expect("written");
    let (out, words, code) = diagnose(&[file.to_str().expect("a path")], "2");
    assert!(out.is_empty() && code == Some(2), "{words}");
    assert!(words.contains("no recording whose readings can be predicted"), "{words}");
}

/// A simulation made elsewhere takes the place of the prediction: against one with the effect, nothing is left.
#[test]
fn against_a_simulation() {
    let expected = testkit::read_fixture("diagnose/warm/expected.json");
    let document = Document::parse(&expected).expect("a document");
    let simulated = simulate::replay(&document, None).expect("replayed").document;
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("simulated.json");
    std::fs::write(&file, common::to_text(&simulated)).expect("written");
    let file = file.to_str().expect("a path");
    let (out, words, code) = diagnose(&["fixtures/diagnose/warm/input.json", "--against", file], "2");
    assert_eq!(code, Some(0), "{words}");
    assert!(words.starts_with("diagnose: agrees"), "{words}");
    let found = Document::parse(&String::from_utf8(out).expect("text")).expect("a document");
    assert_eq!(
        found.recordings,
        Document::parse(&testkit::read_fixture("diagnose/warm/input.json")).expect("a document").recordings
    );

    let (out, words, code) = diagnose(&["fixtures/nasa-1977/table-4.json", "--against", file], "2");
    assert!(out.is_empty() && code == Some(2), "{words}");
    assert!(words.contains("the simulation has none of the document's recordings"), "{words}");
}
