//! The examples in the help texts run as they stand; completions and man pages are there.

const SERIES: &str = env!("CARGO_BIN_EXE_series");

#[test]
fn examples_run() {
    testkit::examples(SERIES, &["cut", "average", "resample", "rename", "join"]);
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(SERIES);
}
