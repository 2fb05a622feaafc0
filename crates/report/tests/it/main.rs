//! The integration tests of `report`: one program, a module for each subject.

mod browser;
mod campaigns;
mod certificate;
mod columns;
mod conformity;
mod findings;
mod golden;
mod laws;
mod program;
mod well_formed;

use common::Document;
use report::{Options, Page};
use serde_json::Value;
use std::fs;

const REPORT: &str = env!("CARGO_BIN_EXE_report");

/// A document or a specification of the fixtures.
fn fixture(name: &str) -> Value {
    serde_json::from_str(&testkit::read_fixture(name)).expect("JSON")
}

fn parsed(document: &Value) -> Document {
    Document::parse(&document.to_string()).expect("a document")
}

fn page(document: &Value) -> Page {
    report::run(&parsed(document), &Options::default()).expect("a page")
}

fn html(document: &Value) -> String {
    report::html::render(&page(document)).expect("HTML")
}

/// The specification of MAGSAT.
fn magsat() -> report::conformity::Spec {
    report::conformity::Spec::parse(&testkit::read_fixture("specs/magsat.json")).expect("a specification")
}

/// Holds a text to a file of the fixtures. BLESS=1 writes it anew; read the difference before it is kept.
fn same(fixture: &str, found: &str) {
    let path = testkit::fixture(fixture);
    if testkit::bless() {
        fs::write(&path, found).expect("written");
    }
    let expected = fs::read_to_string(&path).unwrap_or_default();
    let first = found.lines().zip(expected.lines()).find(|(a, b)| a != b);
    assert!(found == expected, "{fixture}: differs first at {first:?}");
}
