//! Every document of `fixtures/bad/scalarcal`, and every table and piece of its folder `stream`, brings its
//! message, its exit code, and nothing on standard output.

use std::fs;

const SCALARCAL: &str = env!("CARGO_BIN_EXE_scalarcal");

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/scalarcal", SCALARCAL) >= 9);
}

/// A copy of the fixtures with pieces made of the good tables.
fn pieces() -> tempfile::TempDir {
    let folder = testkit::pieces("bad/scalarcal/stream", SCALARCAL, &["good", "later", "in-nanotesla"]);
    let good = fs::read_to_string(folder.path().join("good.json")).expect("a piece");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
    write("cut-short.json", &good[..good.len() / 2]);
    write("later-version.json", &good.replacen("\"version\":2", "\"version\":99", 1));
    write("other-kind.json", &good.replacen("\"scalarcal\"", "\"diffmag\"", 1));
    write("edited.json", &good.replacen("\"rows\":100", "\"rows\":99", 1));
    folder
}

#[test]
fn each_fault_of_long_series_has_its_message() {
    let folder = pieces();
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
    let run = testkit::run_in(
        SCALARCAL,
        folder.path(),
        &["merge", "-q", "later.json", "good.json", "-o", "found.json"],
    );
    assert_eq!(run.message(), "exit code 0\n");
    testkit::faults_in(folder.path(), "bad/scalarcal/stream", SCALARCAL, (&tables, &lines));
}
