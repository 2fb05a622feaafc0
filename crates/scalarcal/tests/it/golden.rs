//! Golden documents, a line a case, and faults with their messages (BLESS=1 writes both anew: read the
//! difference before it is kept), and the program's help.

use common::{Document, to_text};
use scalarcal::{Columns, FitOptions, Options, stream};
use std::fs;

const SCALARCAL: &str = env!("CARGO_BIN_EXE_scalarcal");

fn case(name: &str, input: &str, options: Options) {
    testkit::golden(&format!("scalarcal/{name}"), &format!("scalarcal/{input}/input.json"), |text| {
        let document = Document::parse(text).unwrap_or_else(|error| panic!("{name}: {error}"));
        to_text(&scalarcal::run(document, &options).unwrap_or_else(|error| panic!("{name}: {error}")))
    });
}

#[test]
fn golden() {
    let constant = Options { constant_magnitude: true, ..Options::default() };
    case("meadow", "meadow", Options::default());
    case("meadow-constant", "meadow-constant", constant);
    let windows = FitOptions { windows_s: Some(80.0), ..FitOptions::default() };
    case("meadow-windows", "meadow", Options { fit: windows, ..Options::default() });
    case("three-orbits", "three-orbits", Options { vector: true, ..Options::default() });
}

#[test]
fn pieces() {
    testkit::golden("scalarcal/pieces", "scalarcal/pieces/stated.json", |text| {
        let stated = Document::parse(text).expect("a document");
        let take = |name: &str| {
            partial::take(&Columns, &testkit::fixture(&format!("scalarcal/pieces/{name}.csv")))
                .expect("a piece")
        };
        let joined = partial::merge(vec![take("evening"), take("morning")]).expect("one series");
        to_text(&stream::document(&joined, stated, &FitOptions::default()).expect("a calibration"))
    });
}

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/scalarcal", SCALARCAL) >= 9);
}

#[test]
fn examples_run_and_completions_and_man_pages_are_there() {
    testkit::examples(SCALARCAL, &["stream", "merge"]);
    testkit::manual(SCALARCAL);
}

/// Of tables and of pieces, which are made of the good tables and then damaged.
#[test]
fn each_fault_of_long_series_has_its_message() {
    let folder = testkit::pieces("bad/scalarcal/stream", SCALARCAL, &["good", "later", "in-nanotesla"]);
    let good = fs::read_to_string(folder.path().join("good.json")).expect("a piece");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
    write("cut-short.json", &good[..good.len() / 2]);
    write("later-version.json", &good.replacen("\"version\":2", "\"version\":99", 1));
    write("other-kind.json", &good.replacen("\"scalarcal\"", "\"diffmag\"", 1));
    write("edited.json", &good.replacen("\"rows\":100", "\"rows\":99", 1));
    let tables = [
        "time-backwards",
        "time-missing",
        "time-in-microseconds",
        "no-reference",
        "no-sensor-z",
        "no-rows",
        "five-rows",
        "all-missing",
        "sensor-constant",
        "sensor-copied",
        "reference-in-microtesla",
        "about-one-axis",
    ];
    let lines: [(&str, &[&str]); 11] = [
        ("no-such-file", &["stream", "nowhere.parquet"]),
        ("other-format", &["stream", "rows.xlsx"]),
        ("effects-of-the-model", &["stream", "--document", "effects.json", "good.csv"]),
        ("windows-negative", &["stream", "--windows=-1", "good.csv"]),
        ("merge-twice-the-same", &["merge", "good.json", "good.json"]),
        ("merge-other-unit", &["merge", "later.json", "in-nanotesla.json"]),
        ("merge-later-version", &["merge", "good.json", "later-version.json"]),
        ("merge-other-kind", &["merge", "good.json", "other-kind.json"]),
        ("merge-edited", &["merge", "later.json", "edited.json"]),
        ("merge-cut-short", &["merge", "cut-short.json", "later.json"]),
        ("merge-known-twice", &["merge", "--known", "--document", "found.json", "good.json", "later.json"]),
    ];
    let merge = ["merge", "-q", "later.json", "good.json", "-o", "found.json"];
    assert_eq!(testkit::run_in(SCALARCAL, folder.path(), &merge).message(), "exit code 0\n");
    testkit::faults_in(folder.path(), "bad/scalarcal/stream", SCALARCAL, (&tables, &lines));
}
