//! Every file of `fixtures/bad/ingest` brings its message, its exit code, nothing on standard output and
//! nothing in the folder.

use std::fs;
use std::path::Path;

const INGEST: &str = env!("CARGO_BIN_EXE_ingest");

/// Runs in a folder, so that files are named in messages as they are here: exit code and what was said, what
/// was written.
fn run(folder: &Path, arguments: &[&str]) -> (String, String) {
    let run = testkit::run_in(INGEST, folder, arguments);
    (run.message(), run.stdout)
}

/// A copy of the fixtures, with the files that are too large to be kept.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for entry in fs::read_dir(testkit::fixture("bad/ingest")).expect("fixtures") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            continue;
        }
        fs::copy(&path, folder.path().join(path.file_name().expect("a name"))).expect("copied");
    }
    let names: Vec<String> = (1..=1_000_000).map(|column| format!("c{column}_nT")).collect();
    let row = vec!["1.5"; names.len()].join(",");
    let million = format!("{}\n{row}\n{row}\n", names.join(","));
    fs::write(folder.path().join("million-columns.csv"), million).expect("written");
    folder
}

fn entries(folder: &Path) -> Vec<String> {
    let names = fs::read_dir(folder).expect("readable");
    let mut names: Vec<String> =
        names.map(|entry| entry.expect("an entry").file_name().into_string().expect("UTF-8")).collect();
    names.sort();
    names
}

#[test]
fn each_fault_has_its_message() {
    let folder = folder();
    let before = entries(folder.path());
    let named = |name: &str| {
        let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
        (
            format!("{}-{}", stem, name.rsplit('.').next().unwrap_or_default()),
            vec!["-o".into(), "out.json".into(), name.to_string()],
        )
    };
    let files = [
        "truncated.min",
        "truncated-number.min",
        "truncated-header.min",
        "header-only.min",
        "components-lie.min",
        "interval-lies.min",
        "day-of-year-lies.min",
        "titles-unknown.min",
        "joined-end-to-end.min",
        "no-number.min",
        "time-of-day.min",
        "nothing-observed.min",
        "empty.csv",
        "blank.csv",
        "header-only.csv",
        "truncated.csv",
        "utf-16.csv",
        "utf-16-without-mark.csv",
        "duplicate-times.csv",
        "clock-set-back.csv",
        "unknown-unit.csv",
        "no-unit.csv",
        "more-values.csv",
        "time.csv",
        "day-or-month.csv",
        "spreadsheet.csv",
        "words-only.csv",
        "document.json",
        "list.json",
        "truncated.ndjson",
        "truncated.parquet",
        "time-missing.parquet",
        "million-columns.csv",
        "nowhere.csv",
        "nameless.csv",
        "thousands-doubtful.csv",
        "day-or-month-am.csv",
        "truncated.cdf",
        "short.pcdcp",
        "short-usgs.json",
    ];
    let asked: [(&str, &[&str]); 38] = [
        ("no-file", &[]),
        ("decimal-comma", &["--map", "map-semicolon.json", "decimal-comma.csv"]),
        ("word", &["--map", "map.json", "word.csv"]),
        ("quote-open", &["--map", "map.json", "quote-open.csv"]),
        ("latin-1-in-a-row", &["--map", "map.json", "latin-1-in-a-row.csv"]),
        ("text-for-number", &["--map", "map.json", "text-for-number.ndjson"]),
        ("wrong-separator", &["--map", "map-semicolon.json", "word.csv"]),
        ("million-columns-mapped", &["--map", "map.json", "million-columns.csv"]),
        ("summer-time-ends", &["--map", "map-vienna.json", "summer-time-ends.csv"]),
        ("date-not-in-the-name", &["--map", "map-no-date.json", "word.csv"]),
        ("map-unit-open", &["--map", "map-unit-open.json", "word.csv"]),
        ("map-unit-unknown", &["--map", "map-unit-unknown.json", "word.csv"]),
        ("map-volts", &["--map", "map-volts.json", "word.csv"]),
        ("map-column-absent", &["--map", "map-column-absent.json", "word.csv"]),
        ("map-column-twice", &["--map", "map-column-twice.json", "word.csv"]),
        ("map-column-zero", &["--map", "map-column-zero.json", "word.csv"]),
        ("map-column-by-number", &["--map", "map-column-by-number.json", "text-for-number.ndjson"]),
        ("map-scale-huge", &["--map", "map-scale-huge.json", "word.csv"]),
        ("map-key-unknown", &["--map", "map-key-unknown.json", "word.csv"]),
        ("map-zone", &["--map", "map-zone.json", "word.csv"]),
        ("map-format", &["--map", "map-format.json", "word.csv"]),
        ("map-thousands", &["--map", "map-thousands.json", "bits.csv"]),
        ("map-bits", &["--map", "map-bits.json", "bits.csv"]),
        ("map-valid", &["--map", "map-valid.json", "bits.csv"]),
        ("map-no-day", &["--map", "map-no-day.json", "bits.csv"]),
        ("bits", &["--map", "map-bits-16.json", "bits.csv"]),
        ("seconds-of-day", &["--map", "map-seconds-of-day.json", "seconds-of-day.csv"]),
        ("thousands", &["--map", "map-seconds-of-day.json", "thousands.csv"]),
        ("cdf-variable-absent", &["--map", "map.json", "mission.cdf"]),
        ("map-newer", &["--map", "map-newer.json", "word.csv"]),
        ("map-for-iaga", &["--map", "map.json", "whole.min"]),
        ("map-is-none", &["--map", "document.json", "word.csv"]),
        ("two-stations", &["whole.min", "other-station.min"]),
        ("files-disagree", &["whole.min", "disagrees.min"]),
        ("guess-iaga", &["guess", "whole.min"]),
        ("guess-million-columns", &["guess", "million-columns.csv"]),
        ("table-leaves-the-folder", &["--beside=../secret.parquet", "-o", "out.json", "whole.min"]),
        ("table-of-unknown-kind", &["--beside=table.xlsx", "-o", "out.json", "whole.min"]),
    ];
    let asked = asked.map(|(name, words)| {
        (name.to_string(), words.iter().map(ToString::to_string).collect::<Vec<String>>())
    });
    let mut wrong = Vec::new();
    for (name, arguments) in files.map(named).into_iter().chain(asked) {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let (said, written) = run(folder.path(), &arguments);
        let expected = testkit::fixture(&format!("bad/ingest/messages/{name}.txt"));
        if testkit::bless() {
            fs::create_dir_all(expected.parent().expect("a folder")).expect("a folder");
            fs::write(&expected, &said).expect("written");
        }
        let expected = fs::read_to_string(&expected).unwrap_or_default();
        if said != expected || !written.is_empty() || said.starts_with("exit code 0") {
            wrong.push(format!("{name}:\n{said}{written}where this is expected:\n{expected}"));
        }
        assert_eq!(entries(folder.path()), before, "{name} left something behind");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_is_asked_for_gets_past_a_fault() {
    let folder = folder();
    let ok = |arguments: &[&str]| {
        let (said, written) = run(folder.path(), arguments);
        assert!(said.starts_with("exit code 0"), "{arguments:?}: {said}");
        (said, serde_json::from_str::<serde_json::Value>(&written).expect("a document"))
    };
    let (said, document) = ok(&["--trust-rows", "components-lie.min"]);
    assert!(said.contains("the header says XYZF, the titles say HDZF; the titles are used"), "{said}");
    assert_eq!(document["recordings"][0]["source"]["components"], "HDZF");
    assert!(
        ok(&["--trust-rows", "interval-lies.min"]).0.contains("the rows are 60 s apart; the rows are used")
    );
    ok(&["--trust-rows", "day-of-year-lies.min"]);
    let (said, document) = ok(&["--keep", "last", "whole.min", "disagrees.min"]);
    assert!(said.contains("1 row in which files disagree"), "{said}");
    assert_eq!(document["recordings"][0]["columns"]["sensor_x_nt"][5], 1.0);
    ok(&["--sort", "--keep", "first", "clock-set-back.csv"]);
    ok(&["--keep", "first", "duplicate-times.csv"]);
}

#[test]
fn a_table_stays_in_the_folder_of_the_document() {
    let folder = folder();
    fs::create_dir(folder.path().join("campaign")).expect("a folder");
    let refused = |table: &str| {
        let table = format!("--beside={table}");
        let (said, _) = run(folder.path(), &[&table, "-o", "campaign/out.json", "whole.min"]);
        assert!(said.starts_with("exit code 2"), "{said}");
        assert!(entries(&folder.path().join("campaign")).iter().all(|name| name == "up"), "{said}");
        said
    };
    assert!(refused("../secret.parquet").contains("has .. in it"));
    assert!(refused("/secret.parquet").contains("is absolute"));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.path(), folder.path().join("campaign/up")).expect("a link");
        assert!(refused("up/secret.parquet").contains("leads out of the folder"));
    }
}
