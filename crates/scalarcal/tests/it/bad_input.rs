//! Every document of `fixtures/bad/scalarcal`, and every table and piece of its folder `stream`, brings its message, its exit code,
//! and nothing on standard output.

use std::fs;
use std::path::Path;

const SCALARCAL: &str = env!("CARGO_BIN_EXE_scalarcal");

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/scalarcal", SCALARCAL) >= 9);
}

/// Runs in a folder, so that files are named in messages as they are here: exit code and what was said, what was written.
fn run(folder: &Path, arguments: &[&str]) -> (String, String) {
    let run = testkit::run_in(SCALARCAL, folder, arguments);
    (run.message(), run.stdout)
}

/// A copy of the fixtures with pieces made of the good tables.
fn pieces() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for entry in fs::read_dir(testkit::fixture("bad/scalarcal/stream")).expect("fixtures") {
        let path = entry.expect("an entry").path();
        fs::copy(&path, folder.path().join(path.file_name().expect("a name"))).expect("copied");
    }
    for name in ["good", "later", "in-nanotesla"] {
        let (table, piece) = (format!("{name}.csv"), format!("{name}.json"));
        let (said, _) = run(folder.path(), &["stream", "--partial", &table, "-o", &piece]);
        assert_eq!(said, "exit code 0\n");
    }
    let good = fs::read_to_string(folder.path().join("good.json")).expect("a piece");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
    write("cut-short.json", &good[..good.len() / 2]);
    write("later-version.json", &good.replacen("\"version\":1", "\"version\":99", 1));
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
    let tables = tables.map(|name| (name, vec!["stream".to_string(), format!("{name}.csv")]));
    let files: [(&str, &[&str]); 11] = [
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
    let (said, _) = run(folder.path(), &["merge", "-q", "later.json", "good.json", "-o", "found.json"]);
    assert_eq!(said, "exit code 0\n");
    let files = files.map(|(name, words)| (name, words.iter().map(ToString::to_string).collect()));
    let mut wrong = Vec::new();
    for (name, arguments) in tables.into_iter().chain(files) {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let (said, written) = run(folder.path(), &arguments);
        let expected = testkit::fixture(&format!("bad/scalarcal/stream/{name}.txt"));
        if testkit::bless() {
            fs::write(&expected, &said).expect("written");
        }
        let expected = fs::read_to_string(&expected).unwrap_or_default();
        if said != expected || !written.is_empty() || said.starts_with("exit code 0") {
            wrong.push(format!("{name}:\n{said}{written}where this is expected:\n{expected}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
