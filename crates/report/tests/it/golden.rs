//! Golden pages, a line a case: as text, and as HTML where the page is small. BLESS=1 writes them anew; read
//! the difference before it is kept.

use common::Document;
use page::{html, text};
use report::{Options, Page};
use std::fs;

#[test]
fn golden() {
    for (case, is_html) in [
        ("coilcal/every-procedure", false),
        ("sensorcal/small", false),
        ("axescal/table-4", false),
        ("scalarcal/meadow", false),
        ("diffmag/turned-pair", false),
        ("diagnose/warm", false),
        ("correct/flight", false),
        ("coilcal/uneven", true),
    ] {
        let page = page(&testkit::read_fixture(&format!("{case}/expected.json")));
        let name = case.replace('/', "-");
        match is_html {
            true => same(&format!("{name}.html"), &html::render(&page)),
            false => same(&format!("{name}.txt"), &text::render(&page)),
        }
    }
    let empty = page(r#"{"fluxcal": 1}"#);
    same("empty.txt", &text::render(&empty));
    same("empty.html", &html::render(&empty));
}

fn page(text: &str) -> Page {
    report::run(&Document::parse(text).expect("a document"), &Options::default()).expect("a page")
}

fn same(name: &str, found: &str) {
    let path = testkit::fixture("report").join(name);
    if testkit::bless() {
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::write(&path, found).expect("written");
    }
    let expected = fs::read_to_string(&path).unwrap_or_default();
    let first = found.lines().zip(expected.lines()).find(|(a, b)| a != b);
    assert!(found == expected, "{}: differs first at {first:?}", path.display());
}

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/report", env!("CARGO_BIN_EXE_report")) >= 4);
}
