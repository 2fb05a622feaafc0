//! Laws of files: where they are cut, in which unit they are and how their axes are named changes nothing but
//! that.

use serde_json::{Value, json};
use std::fs;

const INGEST: &str = env!("CARGO_BIN_EXE_ingest");

/// What the recording that files make holds.
fn recording(files: &[&str]) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let names: Vec<String> = (0..files.len()).map(|number| format!("part-{number}.csv")).collect();
    for (name, text) in names.iter().zip(files) {
        fs::write(folder.path().join(name), text).expect("written");
    }
    let mut arguments = vec!["-q", "--inline"];
    arguments.extend(names.iter().map(String::as_str));
    let run = testkit::run_in(INGEST, folder.path(), &arguments);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let document: Value = serde_json::from_str(&run.stdout).expect("JSON");
    let recording = &document["recordings"][0];
    json!({"start": recording["start"], "columns": recording["columns"]})
}

#[test]
fn a_file_in_two_is_the_same_in_any_order() {
    let text = testkit::read_fixture("ingest/field.csv");
    let whole = recording(&[&text]);
    let (header, rows) = text.split_once('\n').expect("a header");
    let rows: Vec<&str> = rows.lines().collect();
    for cut in 4..rows.len() - 4 {
        let part = |rows: &[&str]| format!("{header}\n{}\n", rows.join("\n"));
        let (first, second) = (part(&rows[..cut]), part(&rows[cut..]));
        assert_eq!(recording(&[&first, &second]), whole, "cut before row {cut}");
        assert_eq!(recording(&[&second, &first]), whole, "cut before row {cut}, the second file first");
    }
}

#[test]
fn the_unit_of_a_file_does_not_matter() {
    let text = testkit::read_fixture("ingest/field.csv");
    let cell = |cell: &str| cell.parse().map_or(cell.to_string(), |nt: f64| (nt / 1000.0).to_string());
    let lines = text.replace("_nT", "_uT");
    let lines = lines.lines().map(|line| line.split(',').map(cell).collect::<Vec<_>>().join(","));
    let microtesla = lines.collect::<Vec<_>>().join("\n") + "\n";
    let (found, expected) = (recording(&[&microtesla]), recording(&[&text]));
    for (name, values) in expected["columns"].as_object().expect("columns") {
        for (row, value) in values.as_array().expect("a list").iter().enumerate() {
            let found = found["columns"][name][row].as_f64();
            let close = value.as_f64().zip(found).is_some_and(|(a, b)| (a - b).abs() <= 1e-12 * a.abs());
            assert!(close || (value.is_null() && found.is_none()), "{name}[{row}]: {found:?} for {value}");
        }
    }
}

#[test]
fn the_names_of_the_axes_do_not_matter() {
    let text = testkit::read_fixture("ingest/field.csv");
    let (expected, found) =
        (recording(&[&text]), recording(&[&text.replacen("x_nT,y_nT,z_nT", "y_nT,z_nT,x_nT", 1)]));
    for (old, new) in [("x", "y"), ("y", "z"), ("z", "x")] {
        let column = |of: &Value, axis: &str| of["columns"][format!("sensor_{axis}_nt")].clone();
        assert_eq!(column(&found, new), column(&expected, old), "{old} is called {new}");
    }
}
