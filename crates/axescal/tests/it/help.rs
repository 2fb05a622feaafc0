//! The examples in the help texts run as they stand; completions and man pages are there.

const AXESCAL: &str = env!("CARGO_BIN_EXE_axescal");

#[test]
fn examples_run() {
    testkit::examples(AXESCAL, &[]);
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(AXESCAL);
}
