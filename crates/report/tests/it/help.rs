//! The examples in the help text run as they stand; completions and man pages are there.

const REPORT: &str = env!("CARGO_BIN_EXE_report");

#[test]
fn examples_run() {
    let folder = testkit::examples(REPORT, &[]);
    let page = std::fs::read_to_string(folder.path().join("report.html")).expect("a page");
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(REPORT);
}
