//! The examples in the help texts run as they stand; completions and man pages are there.

const COILCAL: &str = env!("CARGO_BIN_EXE_coilcal");

#[test]
fn examples_run() {
    testkit::examples(COILCAL, &[]);
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(COILCAL);
}
