//! The examples in the help texts run as they stand; completions and man pages are there.

const SIMULATE: &str = env!("CARGO_BIN_EXE_simulate");

#[test]
fn examples_run() {
    testkit::examples(SIMULATE, &["campaign", "observatory", "flight", "replay", "sweep"]);
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(SIMULATE);
}
