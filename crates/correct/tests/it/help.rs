//! The examples in the help text run as they stand; completions and man pages are there.

const CORRECT: &str = env!("CARGO_BIN_EXE_correct");

#[test]
fn examples_run() {
    let folder = testkit::examples(CORRECT, &[]);
    for written in ["result.json", "field.parquet", "field.min"] {
        assert!(folder.path().join(written).exists(), "{written}");
    }
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(CORRECT);
}
