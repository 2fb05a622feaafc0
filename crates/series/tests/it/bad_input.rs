//! Each fault has its message, its exit code and nothing on standard output; readings beside the document are
//! read and written there.

use std::fs;

const SERIES: &str = env!("CARGO_BIN_EXE_series");

fn document() -> String {
    let recording = |id: &str, start: &str, columns: &str| {
        format!(r#"{{"id": "{id}", "procedure": "free_run", {start} "columns": {{{columns}}}}}"#)
    };
    let (first, second) = (r#""start": "2025-03-14T00:00:00Z","#, r#""start": "2025-03-15T00:00:00Z","#);
    let readings = r#""time_s": [0, 1, 2], "sensor_x_nt": [1, 2, 3]"#;
    let (one, two) = (recording("one", first, readings), recording("two", second, readings));
    let later = recording("later", second, r#""time_s": [0, 1], "test_x_nt": [1, 2]"#);
    let back = recording("back", "", r#""time_s": [0, 2, 2], "sensor_x_nt": [1, 2, 3]"#);
    let none = recording("none", "", r#""sensor_x_nt": [1, 2, 3]"#);
    format!("{{\"fluxcal\": 1, \"recordings\": [\n{}\n]}}", [one, two, later, back, none].join(",\n"))
}

#[test]
fn each_fault_has_its_message() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("in.json"), document()).expect("written");
    fs::write(folder.path().join("day.csv"), "time,x_nT\n2025-03-14T00:00:00Z,20900.5\n").expect("written");
    let faults = r#"
average --window 60 day.csv
    day.csv: found lines of values (CSV); expected a fluxcal document. To read it:\n  ingest day.csv | series average …
average --window 0 in.json
    --window
average --window 60 --share 2 in.json
    a number from 0 to 1
average --window 60 --recording three in.json
    there is no recording "three" in the document; expected one of: one, two
average --window 60 --recording back in.json
    recordings[3].columns.time_s: found 2 s after 2 s in row 2 of "back"; expected increasing times; ingest --sort
resample --step 1 --recording none in.json
    recordings[4].columns.time_s: found none in "none"
cut --from yesterday in.json
    expected a moment such as 2025-03-14T12:00:00Z
cut --from 100 --recording one in.json
    no row of "one", which is from 0 s to 2 s, is between the two times
cut --from 2025-03-14T00:00:00Z --recording back in.json
    recordings[3].start: found none in "back"
rename outside=test --recording one --document in.json
    found no column outside among time_s, sensor_x_nt
join one --document in.json
    fewer than two recordings
join one two --document in.json
    found sensor_x_nt, which "one" has too; expected each name once; rename them first: series rename --recording two sensor=NEW
join one later --document in.json
    "one" and "later" have no time in common
"#;
    assert_eq!(testkit::refusals(SERIES, folder.path(), faults), 13);
}

#[test]
fn examples_run_and_completions_and_man_pages_are_there() {
    testkit::examples(SERIES, &["cut", "average", "resample", "rename", "join"]);
    testkit::manual(SERIES);
}

#[test]
fn tables_are_read_and_written_beside() {
    let folder = tempfile::tempdir().expect("a folder");
    let rows: String = (0..40_000).map(|row| format!("{row},{}\n", row % 7)).collect();
    fs::write(folder.path().join("day.csv"), format!("time_s,sensor_x_nt\n{rows}")).expect("written");
    let document =
        r#"{"fluxcal": 1, "recordings": [{"id": "day", "procedure": "free_run", "table": "day.csv"}]}"#;
    fs::write(folder.path().join("in.json"), document).expect("written");
    let ok = |arguments: &[&str]| {
        let run = testkit::run_in(SERIES, folder.path(), arguments);
        assert_eq!(run.code, 0, "{}", run.stderr);
        serde_json::from_str::<serde_json::Value>(&run.stdout).expect("JSON")
    };
    let short = ok(&["average", "--window", "7", "in.json"]);
    assert_eq!(short["recordings"][0]["columns"]["sensor_x_nt"][0], 3.0);
    assert_eq!(short["recordings"][0].get("table"), None);
    let long = ok(&["resample", "--step", "2", "in.json"]);
    assert_eq!(long["recordings"][0]["table"], "day-resample.parquet");
    assert_eq!(long["recordings"][0].get("columns"), None);
    assert!(folder.path().join("day-resample.parquet").is_file());
    assert_eq!(long["history"][0]["arguments"][1], "--step=2");
    // What was read is not written over.
    let path = |name: &str| folder.path().join(name);
    fs::copy(path("day-resample.parquet"), path("day-cut.parquet")).expect("copied");
    fs::write(path("cut.json"), document.replace("day.csv", "day-cut.parquet")).expect("written");
    let run = testkit::run_in(SERIES, folder.path(), &["cut", "--from", "10", "cut.json"]);
    assert!(run.code == 2 && run.stderr.contains("is also read"), "{}", run.stderr);
}
