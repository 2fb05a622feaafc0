//! Golden pages, a line a case: as text, and as HTML where the page is small.

use report::Page;
use report::{html, text};
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
    same("report/coilcal-uneven.html", &bare(&uneven));
    // By simulate, absolute and correct, with few rows of the variometer.
    let observatory = page(&fixture("report/observatory.json"));
    same("report/observatory.txt", &text::render(&observatory));
    same("report/observatory.html", &bare(&observatory));
    let empty = page(&json!({"fluxcal": 1}));
    same("report/empty.txt", &text::render(&empty));
    same("report/empty.html", &bare(&empty));
}

/// The HTML of a page without its style and its script, which have files of their own.
fn bare(page: &Page) -> String {
    let whole = html::render(page).expect("HTML");
    let (head, rest) = whole.split_once("<style>").expect("a style");
    let (_, rest) = rest.split_once("</style>").expect("its end");
    let (body, rest) = rest.split_once("<script>").expect("a script");
    let (_, foot) = rest.split_once("</script>").expect("its end");
    [head, "<style/>", body, "<script/>", foot].concat()
}

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/report", REPORT) >= 4);
}
