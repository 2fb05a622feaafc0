//! Tables in every format give what the document gives, in pieces or whole.

use common::{AdoptedEffect, Axis, Document, Model, Quantity};
use correct::{Frame, Observatory, Request, Station, correct_table};
use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tables::{Reader, Writer};

const CORRECT: &str = env!("CARGO_BIN_EXE_correct");

fn input() -> Document {
    Document::parse(&testkit::read_fixture("correct/flight/input.json")).expect("a document")
}

/// A table as it is read: names, and columns.
fn read(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let reader = Reader::open(path, None).expect("a table");
    let names = reader.columns().to_vec();
    let mut columns = vec![Vec::new(); names.len()];
    for batch in reader {
        let batch = batch.expect("a batch");
        columns.iter_mut().zip(batch.columns).for_each(|(column, more)| column.extend(more));
    }
    (names, columns)
}

fn write(path: &Path, columns: &[(&str, Vec<f64>)], from: usize) {
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let values: Vec<&[f64]> = columns.iter().map(|(_, values)| &values[from..]).collect();
    let mut writer = Writer::create(path, &names).expect("a table");
    writer.write(&values).expect("written");
    writer.finish().expect("finished");
}

fn request<'a>(calibration: &'a Document, input: &'a Path, output: &'a Path) -> Request<'a> {
    let (input, output) = (Some(input), Some(output));
    Request { recording: Some("flight"), frame: Frame::Geo, input, output, ..Request::of(calibration) }
}

fn all_same(one: &[f64], other: &[f64]) -> bool {
    let same = |a: f64, b: f64| a == b || (a.is_nan() && b.is_nan()) || (a - b).abs() < 1e-9;
    one.len() == other.len() && one.iter().zip(other).all(|(a, b)| same(*a, *b))
}

#[test]
fn every_format_gives_what_the_document_gives() {
    let folder = tempfile::tempdir().expect("a folder");
    let calibration = input();
    let expected = correct::run(input(), Frame::Geo).expect("corrected");
    let expected = &expected.recordings[0];
    let mut last: PathBuf = testkit::fixture("correct/flight/readings.csv");
    // From one format into the next; a second correction replaces the columns of the first.
    for name in ["field.parquet", "field.ndjson", "field.csv"] {
        let next = folder.path().join(name);
        correct_table(&request(&calibration, &last, &next)).expect("corrected");
        let (names, columns) = read(&next);
        assert_eq!(names, expected.columns.keys().cloned().collect::<Vec<_>>());
        for (name, column) in names.iter().zip(columns) {
            let expected = expected.column(name).expect("a column");
            assert!(all_same(&column, expected), "{name}: {column:?} {expected:?}");
        }
        last = next;
    }
}

/// Readings of many rows.
fn long(rows: usize) -> Vec<(&'static str, Vec<f64>)> {
    let series = |f: fn(f64) -> f64| (0..rows).map(|row| f(row as f64)).collect::<Vec<f64>>();
    vec![
        ("time_s", series(|t| t)),
        ("sensor_temperature_c", series(|t| 23.0 + 10.0 * (t / 900.0).sin())),
        ("sensor_x_v", series(|t| 7.0 * (t / 31.0).sin())),
        ("sensor_y_v", series(|t| 6.0 * (t / 43.0).cos())),
        ("sensor_z_v", series(|t| 5.0 + (t / 29.0).sin())),
    ]
}

#[test]
fn many_pieces_are_one_series() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let rows = 150_000;
    let columns = long(rows);
    write(&path("long.parquet"), &columns, 0);
    let from = 149_000;
    write(&path("end.parquet"), &columns, from);
    let mut calibration = input();
    for effects in [true, false] {
        if !effects {
            calibration.model = None;
        }
        for name in ["long", "end"] {
            let (from, to) = (path(&format!("{name}.parquet")), path(&format!("{name}-field.parquet")));
            correct_table(&request(&calibration, &from, &to)).expect("corrected");
        }
        let (_, whole) = read(&path("long-field.parquet"));
        let (_, end) = read(&path("end-field.parquet"));
        for (whole, end) in whole.iter().zip(&end) {
            assert_eq!(whole.len(), rows);
            assert!(all_same(&whole[from..], end));
        }
    }
}

#[test]
fn a_matrix_gives_what_the_passes_give() {
    // An effect of no size makes the chain go row by row.
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    write(&path("long.csv"), &long(300), 0);
    let mut calibration = input();
    let corrected = [true, false].map(|passes| {
        let nothing = AdoptedEffect {
            effect: "quadratic_nonlinearity".into(),
            sensor: Some(Axis::X),
            parameters: [("departure_nt".to_string(), Quantity::Bare(0.0))].into_iter().collect(),
            ..AdoptedEffect::default()
        };
        let effects = if passes { vec![nothing] } else { Vec::new() };
        calibration.model = Some(Model { effects, ..Model::default() });
        let to = path("field.csv");
        correct_table(&request(&calibration, &path("long.csv"), &to)).expect("corrected");
        read(&to).1
    });
    for (passes, matrix) in corrected[0].iter().zip(&corrected[1]) {
        assert!(all_same(passes, matrix));
    }
}

#[test]
fn an_effect_that_remembers_takes_the_series_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let columns = long(70_000);
    write(&path("long.csv"), &columns, 0);
    let mut calibration = input();
    let model = calibration.model.as_mut().expect("a model");
    model.effects[0].effect = "sensitivity_temperature_lag".into();
    model.effects[0].parameters = [("coefficient_ppm_per_k", 28.0), ("lag_s", 3000.0)]
        .map(|(k, v)| (k.to_string(), Quantity::Bare(v)))
        .into_iter()
        .collect();
    correct_table(&request(&calibration, &path("long.csv"), &path("field.csv"))).expect("corrected");
    let (names, found) = read(&path("field.csv"));
    // As a recording of the document.
    let mut document = calibration.clone();
    for (name, values) in columns {
        document.recordings[0].columns.insert(name.into(), values.into());
    }
    let document = correct::run(document, Frame::Geo).expect("corrected");
    for (name, column) in names.iter().zip(found) {
        let expected = document.recordings[0].column(name).expect("a column");
        assert!(all_same(&column, expected), "{name}");
    }
}

#[test]
fn a_stream_goes_through_and_a_closed_pipe_is_quiet() {
    let calibration = testkit::fixture("correct/flight/input.json");
    let calibration = calibration.to_str().expect("UTF-8");
    let readings = testkit::read_fixture("correct/flight/readings.csv");
    let arguments = ["--calibration", calibration, "--from", "csv", "--to", "ndjson", "-"];
    let run = testkit::run(CORRECT, &arguments, &readings);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(run.stdout.lines().count(), 24);
    assert!(run.stderr.starts_with("correct: 23 of 24 rows have a field in SEN\n"), "{}", run.stderr);

    let folder = tempfile::tempdir().expect("a folder");
    let long_csv = folder.path().join("long.csv");
    write(&long_csv, &long(100_000), 0);
    let mut child = Command::new(CORRECT)
        .args(["--calibration", calibration])
        .arg(&long_csv)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("correct");
    let mut first = [0; 100];
    let mut stdout = child.stdout.take().expect("piped");
    stdout.read_exact(&mut first).expect("the first bytes");
    drop(stdout);
    let output = child.wait_with_output().expect("ended");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_table_without_rows_keeps_its_header() {
    let calibration = testkit::fixture("correct/flight/input.json");
    let arguments = ["-q", "--calibration", calibration.to_str().expect("UTF-8"), "--from", "csv"];
    let run = testkit::run(CORRECT, &arguments, "time_s,sensor_x_v,sensor_y_v,sensor_z_v\n");
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
    assert!(run.stdout.starts_with("time_s,sensor_x_v,sensor_y_v,sensor_z_v,field_x_nt,"), "{}", run.stdout);
}

#[test]
fn nothing_is_half_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let bad = folder.path().join("bad.csv");
    let mut text = fs::read_to_string(testkit::fixture("correct/flight/readings.csv")).expect("readings");
    text.push_str("24.0,23.0,nought,1,2\n");
    fs::write(&bad, text).expect("written");
    let output = folder.path().join("field.csv");
    let error = correct_table(&request(&input(), &bad, &output)).expect_err("a word");
    assert!(error.to_string().contains("bad.csv, line 26, column 3 (sensor_x_v)"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
}

/// A day of an observatory: the file that is written holds the corrected field of each row to the hundredth.
#[test]
fn iaga_2002_holds_the_field() {
    let folder = tempfile::tempdir().expect("a folder");
    let calibration = input();
    let (readings, output) = (testkit::fixture("correct/flight/readings.csv"), folder.path().join("day.min"));
    let start = Some("2026-02-28T23:59:58.5Z");
    let station = Station { format: Observatory::Iaga, code: "flx", start, place: None };
    let asked = Request { station: Some(station), ..request(&calibration, &readings, &output) };
    let rows = correct_table(&asked).expect("written");
    let text = fs::read_to_string(&output).expect("a file");
    let lines: Vec<&str> = text.lines().collect();
    let (header, data): (Vec<&str>, Vec<&str>) = lines.iter().partition(|line| line.ends_with('|'));
    assert!(header.iter().all(|line| line.len() == 70), "{header:?}");
    assert_eq!(header[3], format!("{:<69}|", " IAGA CODE              FLX"));
    let titles = "DATE       TIME         DOY     FLXX      FLXY      FLXZ      FLXF";
    assert_eq!(header[13], format!("{titles:<69}|"));
    let expected = correct::run(input(), Frame::Geo).expect("corrected");
    let recording = &expected.recordings[0];
    assert_eq!(data.len(), recording.rows());
    assert!(data[0].starts_with("2026-02-28 23:59:58.500 059  "), "{}", data[0]);
    assert!(data[2].starts_with("2026-03-01 "), "{}", data[2]);
    for (row, line) in data.iter().enumerate() {
        let found: Vec<f64> =
            line[27..].split_whitespace().map(|value| value.parse().expect("a number")).collect();
        for (value, axis) in found.iter().zip(Axis::ALL) {
            let field = recording.axis_column("field_geo", axis, "nt").expect("a column")[row];
            let due = if field.is_finite() { field } else { 99_999.0 };
            assert!((value - due).abs() <= 0.005 + 1e-9, "{line}: {due}");
        }
        assert_eq!(found[3], 88_888.0);
    }
    assert!(!rows.is_empty());
    let without = Request { station: Some(Station { start: None, ..station }), ..asked };
    let without = Request { recording: None, ..without };
    let error = correct_table(&without).expect_err("no start").to_string();
    assert!(error.contains("the origin of time_s is unknown"), "{error}");
    let error = correct_table(&Request { station: Some(Station { code: "Vienna", ..station }), ..asked });
    assert!(error.expect_err("no code").to_string().contains("is not a station code"));
}

/// A logger's file by a mapping gives what the table with the document's names gives: the same columns, in
/// other notation.
#[test]
fn a_mapping_is_read_as_ingest_reads_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let table = testkit::read_fixture("correct/flight/readings.csv");
    let logger = testkit::read_fixture("correct/logger.csv");
    let mapping = testkit::read_fixture("correct/logger-map.json");
    for (name, text) in [
        ("readings.csv", table.as_str()),
        ("logger.txt", &logger),
        ("map.json", &mapping),
        ("flight.json", &testkit::read_fixture("correct/flight/input.json")),
    ] {
        fs::write(folder.path().join(name), text).expect("written");
    }
    let correct = |arguments: &[&str]| {
        let all = [&["--calibration", "flight.json"], arguments].concat();
        let run = testkit::run_in(CORRECT, folder.path(), &all);
        assert_eq!(run.code, 0, "{}", run.stderr);
        (run.stdout, run.stderr)
    };
    let (direct, _) = correct(&["readings.csv"]);
    let (mapped, said) = correct(&["--map", "map.json", "logger.txt"]);
    assert!(said.contains("from 1 file of CSV") && said.contains("correct: 23 of 24 rows"), "{said}");
    // The values of each column by its name.
    let sorted = |text: &str| {
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        let of = |(column, name): (usize, &&str)| {
            let values = lines[1..].iter().map(|row| row[column].parse::<f64>().ok()).collect();
            (name.to_string(), values)
        };
        lines[0].iter().enumerate().map(of).collect::<BTreeMap<String, Vec<_>>>()
    };
    assert_eq!(sorted(&direct), sorted(&mapped));
    // IAGA-2002 describes its own columns; without sensitivities in V its readings in nT are what is
    // corrected.
    fs::copy(testkit::fixture("ingest/lemi.sec"), folder.path().join("lemi.sec")).expect("copied");
    let (iaga, said) = correct(&["lemi.sec"]);
    assert!(said.contains("IAGA-2002") && iaga.starts_with("time_s,"), "{said}");
}
