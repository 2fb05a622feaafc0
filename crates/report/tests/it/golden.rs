//! Golden pages, a line a case: as text, and as HTML where the page is small. BLESS=1 writes them anew; read
//! the difference before it is kept.

use common::Document;
use page::{html, text};
use report::Options;
use std::fs;

#[test]
fn golden() {
    as_text("coilcal/every-procedure");
    as_text("sensorcal/small");
    as_text("axescal/table-4");
    as_text("scalarcal/meadow");
    as_text("diffmag/turned-pair");
    as_text("diagnose/warm");
    as_text("correct/flight");
    as_html("coilcal/uneven");
    let empty = report::run(&Document::parse(r#"{"fluxcal": 1}"#).expect("a document"), &Options::default());
    let empty = empty.expect("a page");
    same("empty.txt", &text::render(&empty));
    same("empty.html", &html::render(&empty));
}

fn as_text(case: &str) {
    same(&format!("{}.txt", case.replace('/', "-")), &text::render(&page(case)));
}

fn as_html(case: &str) {
    same(&format!("{}.html", case.replace('/', "-")), &html::render(&page(case)));
}

/// The page of another stage's golden document.
fn page(case: &str) -> report::Page {
    let text = testkit::read_fixture(&format!("{case}/expected.json"));
    let document = Document::parse(&text).expect("a document");
    report::run(&document, &Options::default()).expect("a page")
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
