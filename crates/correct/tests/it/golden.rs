use common::{Document, to_text};
use correct::Frame;

const CORRECT: &str = env!("CARGO_BIN_EXE_correct");

#[test]
fn golden() {
    for (case, frame) in [("correct/flight", Frame::Sen), ("correct/flight-geo", Frame::Geo)] {
        testkit::golden(case, "correct/flight/input.json", |text| {
            let document = Document::parse(text).expect("a document");
            to_text(&correct::run(document, frame).expect("corrected"))
        });
    }
}

#[test]
fn examples_run_and_completions_and_man_pages_are_there() {
    let folder = testkit::examples(CORRECT, &[]);
    for written in ["result.json", "field.parquet", "field.min"] {
        assert!(folder.path().join(written).exists(), "{written}");
    }
    testkit::manual(CORRECT);
}
