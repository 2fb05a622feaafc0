//! Golden pages, a line a case: as text, and as HTML where the page is small.

use report::page::{html, text};
use serde_json::json;

use crate::{REPORT, fixture, page, same};

#[test]
fn golden() {
    for case in [
        "coilcal/every-procedure",
        "sensorcal/small",
        "axescal/table-4",
        "scalarcal/meadow",
        "diffmag/turned-pair",
        "diagnose/warm",
        "correct/flight",
    ] {
        let page = page(&fixture(&format!("{case}/expected.json")));
        same(&format!("report/{}.txt", case.replace('/', "-")), &text::render(&page));
    }
    let uneven = page(&fixture("coilcal/uneven/expected.json"));
    same("report/coilcal-uneven.html", &html::render(&uneven).expect("HTML"));
    let empty = page(&json!({"fluxcal": 1}));
    same("report/empty.txt", &text::render(&empty));
    same("report/empty.html", &html::render(&empty).expect("HTML"));
}

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/report", REPORT) >= 4);
}
