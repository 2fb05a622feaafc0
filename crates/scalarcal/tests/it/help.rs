//! The examples in the help texts run as they stand; completions and man pages are there.

const SCALARCAL: &str = env!("CARGO_BIN_EXE_scalarcal");

#[test]
fn examples_run() {
    testkit::examples(SCALARCAL, &[]);
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(SCALARCAL);
}
