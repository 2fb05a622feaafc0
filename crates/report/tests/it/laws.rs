//! Laws over documents of all stages: what does not matter to a page. FLUXCAL_CAMPAIGNS sets how many orders
//! are drawn.
//!
//! A page shows numbers and estimates none: other names of axes, units, frames, noise and reference
//! temperatures are other numbers to show, which golden pages hold.

use report::text;
use serde_json::Value;
use testkit::laws;

use crate::{fixture, page};

fn each(law: impl Fn(&Value)) {
    for case in [
        "coilcal/every-procedure",
        "sensorcal/small",
        "axescal/table-4",
        "diffmag/turned-pair",
        "diagnose/warm",
        "correct/flight",
    ] {
        law(&fixture(&format!("{case}/expected.json")));
    }
}

#[test]
fn unknown_keys_change_nothing() {
    each(|document| {
        let mut asked = laws::unknown_keys(document);
        // In what the stages found, many objects have data for keys.
        for found in ["calibration", "diagnosis"].iter().filter(|found| !document[**found].is_null()) {
            asked[*found] = document[*found].clone();
        }
        assert_eq!(text::render(&page(&asked)), text::render(&page(document)));
    });
}

/// Recordings are shown in the document's order, so lines are held against each other sorted.
#[test]
fn the_order_of_recordings_changes_no_line() {
    let lines = |document: &Value| {
        let mut lines: Vec<String> = text::render(&page(document)).lines().map(str::to_string).collect();
        lines.sort();
        lines
    };
    for seed in 0..testkit::campaigns(4) {
        each(|document| {
            let (found, expected) = (lines(&laws::reorder(document, seed)), lines(document));
            let first = found.iter().zip(&expected).find(|(found, expected)| found != expected);
            assert!(first.is_none() && found.len() == expected.len(), "{}: {first:#?}", document["title"]);
        });
    }
}
