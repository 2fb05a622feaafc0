//! The examples in the help texts run as they stand; completions and man pages are there.

const DIAGNOSE: &str = env!("CARGO_BIN_EXE_diagnose");

#[test]
fn examples_run() {
    testkit::examples(DIAGNOSE, &[]);
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(DIAGNOSE);
}
