//! The program by itself: the examples of its help, and a fault that leaves the page of before.

use std::fs;

use crate::REPORT;

#[test]
fn examples_run() {
    let folder = testkit::examples(REPORT, &[]);
    let page = fs::read_to_string(folder.path().join("report.html")).expect("a page");
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
}

#[test]
fn completions_and_man_pages() {
    testkit::manual(REPORT);
}

#[test]
fn a_fault_leaves_the_page_of_before() {
    let folder = tempfile::tempdir().expect("a folder");
    let page = folder.path().join("report.html");
    fs::write(&page, "before").expect("written");
    let path = page.to_str().expect("UTF-8");
    let run = testkit::run(REPORT, &["-o", path], "{\"fluxcal\": 2}");
    assert_eq!((run.code, run.stdout.as_str()), (2, ""));
    assert_eq!(fs::read_to_string(&page).expect("there"), "before");
    let run = testkit::run(REPORT, &["-o", path, "absent.json"], "");
    assert_eq!(run.code, 2);
    assert!(run.stderr.starts_with("report: absent.json: cannot be read"), "{}", run.stderr);
    assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 1);
}
