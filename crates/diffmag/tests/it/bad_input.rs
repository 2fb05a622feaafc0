//! Every document of `fixtures/bad/diffmag`, and every table and piece of its folder `stream`, brings its
//! message, its exit code, and nothing on standard output.

use std::fs;

const DIFFMAG: &str = env!("CARGO_BIN_EXE_diffmag");

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/diffmag", DIFFMAG) >= 22);
}

/// A copy of the fixtures with pieces made of the good tables.
fn pieces() -> tempfile::TempDir {
    let folder =
        testkit::pieces("bad/diffmag/stream", DIFFMAG, &["first", "second", "second-each-ten-seconds"]);
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
    let lines: [(&str, &[&str]); 11] = [
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
    testkit::faults_in(folder.path(), "bad/diffmag/stream", DIFFMAG, (&tables, &lines));
    let run = testkit::run_in(DIFFMAG, folder.path(), &["merge", "-q", "second.json", "first.json"]);
    assert_eq!(run.message(), "exit code 0\n");
}
