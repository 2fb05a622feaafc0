//! Every page is well-formed, whatever stands in the document; every plot is drawn, and every link leads
//! somewhere.

use report::{Item, Options, Page};
use report::{html, text};
use roxmltree::{Document as Xml, Node, ParsingOptions};
use serde_json::json;
use std::collections::HashSet;

use crate::{fixture, page, parsed};

const CASES: [&str; 15] = [
    "coilcal/every-procedure",
    "coilcal/uneven",
    "sensorcal/small",
    "axescal/magsat",
    "axescal/one-sensor",
    "axescal/table-4-free-scales",
    "diffmag/pieces",
    "simulate/every-procedure",
    "axescal/magsat-known-coils",
    "diffmag/turned-pair",
    "diagnose/warm",
    "diagnose/delay",
    "correct/flight",
    "correct/flight-geo",
    "ingest/logger",
];

fn check(case: &str, page: &Page) -> String {
    let html = html::render(page).expect("HTML");
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let xml = Xml::parse_with_options(&html, options).unwrap_or_else(|error| panic!("{case}: {error}"));
    let elements = || xml.descendants().filter(Node::is_element);
    assert!(elements().all(|node| !["iframe", "img", "link"].contains(&node.tag_name().name())), "{case}");
    for script in elements().filter(|node| node.tag_name().name() == "script") {
        assert_eq!(script.attribute("src"), None, "{case}");
        if script.attribute("type") == Some("application/json") {
            let data: serde_json::Value =
                serde_json::from_str(script.text().unwrap_or_default()).expect("JSON");
            assert!(data["series"].as_array().is_some_and(|all| !all.is_empty()), "{case}: {data}");
        }
    }
    let mut ids = HashSet::new();
    for id in elements().filter_map(|node| node.attribute("id")) {
        assert!(ids.insert(id), "{case}: the id {id} twice");
    }
    for node in elements().filter(|node| node.tag_name().name() == "a") {
        let href = node.attribute("href").expect("a link");
        let inside = href.strip_prefix('#').is_some_and(|id| ids.contains(id));
        assert!(inside || href.starts_with("data:text/csv;"), "{case}: {href}");
    }
    let named = |node: &Node<'_, '_>, name: &str| node.tag_name().name() == name;
    let figures: Vec<Node<'_, '_>> = elements().filter(|node| named(node, "figure")).collect();
    let plots =
        page.sections.iter().flat_map(|section| &section.items).filter(|item| matches!(item, Item::Plot(_)));
    assert_eq!(figures.len(), plots.count(), "{case}");
    for figure in &figures {
        let id = figure.attribute("id").expect("an id");
        let path = |node: &Node<'_, '_>| {
            named(node, "path") && matches!(node.attribute("class"), Some("points" | "line" | "dashes"))
        };
        let nothing = figure.descendants().any(|node| node.attribute("class") == Some("nothing"));
        assert!(nothing || figure.descendants().any(|node| path(&node)), "{case}: {id} is not drawn");
        assert!(
            figure.descendants().any(|node| node.attribute("download").is_some()),
            "{case}: {id} without data"
        );
        for d in figure.descendants().filter_map(|node| node.attribute("d")) {
            assert!(!d.contains("NaN") && !d.contains("inf"), "{case}: {id}: {d}");
        }
    }
    for table in elements().filter(|node| named(node, "table")) {
        let width = |row: Node<'_, '_>| row.children().filter(Node::is_element).count();
        let rows: HashSet<usize> = table.descendants().filter(|node| named(node, "tr")).map(width).collect();
        assert_eq!(rows.len(), 1, "{case}: {:?}", table.attribute("aria-label"));
    }
    html
}

#[test]
fn every_fixture_gives_a_page() {
    for case in CASES {
        let page = page(&fixture(&format!("{case}/expected.json")));
        assert!(!page.sections.is_empty(), "{case}");
        check(case, &page);
    }
    check("observatory", &page(&fixture("report/observatory.json")));
    check("flight", &page(&fixture("starcal/day/expected.json")));
    check("empty", &page(&json!({"fluxcal": 1})));
}

/// Titles and ids that are markup, ids that come to the same link, readings that are missing, all alike, or
/// huge.
#[test]
fn a_hostile_document_is_shown_as_it_is() {
    let document = r#"{"fluxcal": 1, "title": "<script>alert(1)</script> & \u0001\u001b[2J \"x\"",
        "instrument": {"name": "<img src=x onerror=alert(2)>"},
        "recordings": [
            {"id": "a b", "procedure": "free_run", "columns": {"time_s": [0, 1, 2], "sensor_x_nt": [null, null, null], "sensor_y_nt": [5, 5, 5]}},
            {"id": "a_b", "procedure": "<i>", "columns": {"time_s": [0, 1, 2], "</svg><script>_nt": [1e9, -1e9, 0], "b_v": [null, 2, 1e6]}},
            {"id": "''\"><p>", "procedure": "free_run", "table": "x.csv"},
            {"id": "…", "procedure": "free_run", "columns": {"one": [1]}}],
        "diagnosis": [{"verdict": "unexplained", "series": [{"column": "x<y", "along": "time_s", "x": [0, 1], "before_nt": [1e-300, 2e-300], "after_nt": [1]}]}],
        "history": [{"stage": "<b>", "version": "1", "arguments": ["--a=<"]}]}"#;
    let document = serde_json::from_str(document).expect("JSON");
    let page = page(&document);
    let html = check("hostile", &page);
    let scripts = html.matches("<script").count();
    assert_eq!(scripts, 1 + html.matches("<figure").count(), "those of the page and of its plots");
    for markup in ["<script>alert", "</svg><script", "<img", "<i>", "<p>&quot;", "\u{1b}", "\u{1}"] {
        assert!(!html.contains(markup), "{markup}");
    }
    assert!(!text::render(&page).contains('\u{1b}'));
    // Without a diagnosis the recordings are drawn.
    let mut bare = parsed(&document);
    bare.diagnosis = None;
    // A document with such readings is refused; the page stands them none the less.
    bare.recordings[1].columns["</svg><script>_nt"] = vec![1e308, -1e308, 0.0].into();
    bare.recordings[1].columns["b_v"] = vec![f64::NAN, 2.0, 1e300].into();
    let page = report::run(&bare, &Options::default()).expect("a page");
    let html = check("hostile, drawn", &page);
    assert!(
        html.contains("No value that can be drawn.") && html.contains("Not drawn, missing or not finite"),
        "{html}"
    );
}
