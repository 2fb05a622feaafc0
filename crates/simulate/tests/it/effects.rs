//! The catalogue as people and programs read it; docs/effects.md is made from it. BLESS=1 writes the page
//! anew.

use serde_json::Value;
use std::fs;
use std::path::Path;

const SIMULATE: &str = env!("CARGO_BIN_EXE_simulate");

#[test]
fn the_page_is_what_the_catalogue_says() {
    let run = testkit::run(SIMULATE, &["effects", "--layout", "markdown"], "");
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/effects.md");
    if testkit::bless() {
        fs::write(&page, &run.stdout).expect("written");
    }
    let committed = fs::read_to_string(&page).expect("docs/effects.md");
    assert!(committed == run.stdout, "the catalogue has changed: run with BLESS=1, read it, commit it");
}

#[test]
fn json_holds_every_effect_with_its_ranges() {
    let run = testkit::run(SIMULATE, &["effects", "--layout", "json"], "");
    let effects: Vec<Value> = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!(effects.len(), 57);
    for effect in &effects {
        for key in ["effect", "title", "physics", "equation", "source", "family", "place", "acts_on"] {
            assert!(effect[key].as_str().is_some_and(|text| !text.is_empty()), "{effect}");
        }
        for parameter in effect["parameters"].as_array().expect("a list") {
            let moment = parameter["role"] == "epoch" && parameter["absent"].is_null();
            assert_eq!(parameter["plausible"].as_array().map(Vec::len), (!moment).then_some(2), "{effect}");
        }
    }
}

#[test]
fn one_effect_or_a_name_that_is_none() {
    let run = testkit::run(SIMULATE, &["effects", "perming"], "");
    let begins = "own_field\n  perming: offset steps after a large field\n";
    assert!(run.stdout.starts_with(begins), "{}", run.stdout);
    let run = testkit::run(SIMULATE, &["effects", "gremlins"], "");
    assert_eq!((run.code, run.stdout.as_str()), (2, ""));
    assert!(run.stderr.contains("there is no effect \"gremlins\"; expected one of quadratic_nonlinearity"));
}
