//! The examples in the help texts run as they stand; completions and man pages are there.

const SENSORCAL: &str = env!("CARGO_BIN_EXE_sensorcal");

#[test]
fn examples_run() {
    testkit::examples(SENSORCAL, &[]);
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(SENSORCAL);
}
