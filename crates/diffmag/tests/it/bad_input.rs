//! Every document of `fixtures/bad/diffmag`, and every table and piece of its folder `stream`, brings its message, its exit code,
//! and nothing on standard output.

use std::fs;
use std::path::Path;

const DIFFMAG: &str = env!("CARGO_BIN_EXE_diffmag");

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/diffmag", DIFFMAG) >= 22);
}

/// Runs in a folder, so that files are named in messages as they are here: exit code and what was said, what was written.
fn run(folder: &Path, arguments: &[&str]) -> (String, String) {
    let run = testkit::run_in(DIFFMAG, folder, arguments);
    (run.message(), run.stdout)
}

/// A copy of the fixtures with pieces made of the good tables.
fn pieces() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for entry in fs::read_dir(testkit::fixture("bad/diffmag/stream")).expect("fixtures") {
        let path = entry.expect("an entry").path();
        fs::copy(&path, folder.path().join(path.file_name().expect("a name"))).expect("copied");
    }
    for name in ["first", "second", "second-each-ten-seconds"] {
        let (table, piece) = (format!("{name}.csv"), format!("{name}.json"));
        let (said, _) = run(folder.path(), &["stream", "--partial", &table, "-o", &piece]);
        assert_eq!(said, "exit code 0\n");
    }
    let first = fs::read_to_string(folder.path().join("first.json")).expect("a piece");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("written");
    write("cut-short.json", &first[..first.len() / 2]);
    let edited = first.replacen("\"covered\":[[0,159]]", "\"covered\":[[159,0]]", 1);
    assert_ne!(first, edited);
    write("edited.json", &edited);
    folder
}

#[test]
fn each_fault_of_long_series_has_its_message() {
    let folder = pieces();
    let tables = [
        "time-backwards",
        "time-off-the-grid",
        "time-uneven",
        "time-missing",
        "column-missing",
        "four-rows",
        "no-rows",
        "channel-constant",
        "channels-equal",
        "channel-copied",
        "field-in-a-plane",
        "test-in-volts",
        "test-all-missing",
        "word-in-a-column",
    ];
    let tables = tables.map(|name| (name, vec!["stream".to_string(), format!("{name}.csv")]));
    let files: [(&str, &[&str]); 11] = [
        ("truncated-parquet", &["stream", "truncated.parquet"]),
        ("no-such-file", &["stream", "nowhere.parquet"]),
        ("other-format", &["stream", "pair.xlsx"]),
        ("step-negative", &["stream", "--step-s=-1", "first.csv"]),
        ("merge-twice-the-same", &["merge", "first.json", "first.json"]),
        ("merge-other-step", &["merge", "first.json", "second-each-ten-seconds.json"]),
        ("merge-later-version", &["merge", "first.json", "later-version.json"]),
        ("merge-other-kind", &["merge", "first.json", "other-kind.json"]),
        ("merge-edited", &["merge", "first.json", "edited.json"]),
        ("merge-cut-short", &["merge", "cut-short.json", "second.json"]),
        ("merge-not-a-piece", &["merge", "first.json", "not-a-piece.json"]),
    ];
    let files = files.map(|(name, words)| (name, words.iter().map(ToString::to_string).collect()));
    let mut wrong = Vec::new();
    for (name, arguments) in tables.into_iter().chain(files) {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let (said, written) = run(folder.path(), &arguments);
        let expected = testkit::fixture(&format!("bad/diffmag/stream/{name}.txt"));
        if testkit::bless() {
            fs::write(&expected, &said).expect("written");
        }
        let expected = fs::read_to_string(&expected).unwrap_or_default();
        if said != expected || !written.is_empty() || said.starts_with("exit code 0") {
            wrong.push(format!("{name}:\n{said}{written}where this is expected:\n{expected}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let (said, _) = run(folder.path(), &["merge", "-q", "second.json", "first.json"]);
    assert_eq!(said, "exit code 0\n");
}
