//! Golden documents, a line a case (BLESS=1 writes them anew: read the difference), faults, help.

use common::{Document, to_text};

const SENSORCAL: &str = env!("CARGO_BIN_EXE_sensorcal");

#[test]
fn golden() {
    testkit::golden("sensorcal/small", "sensorcal/small/input.json", |text| {
        to_text(&crate::build::calibrated(Document::parse(text).expect("a document")))
    });
}

#[test]
fn readings_in_files_beside_the_document() {
    testkit::beside(SENSORCAL, "sensorcal/small/input.json");
}

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/sensorcal", SENSORCAL) >= 30);
}

#[test]
fn examples_run_and_completions_and_man_pages_are_there() {
    testkit::examples(SENSORCAL, &[]);
    testkit::manual(SENSORCAL);
}
