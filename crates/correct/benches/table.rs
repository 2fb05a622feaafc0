//! `correct` on a long table, against reading and writing its result alone. `FLUXCAL_ROWS` says how long.

use common::Document;
use correct::{Request, correct_table};
use std::path::Path;
use std::time::Instant;
use tables::{Reader, Writer};

fn main() {
    let rows: usize =
        std::env::var("FLUXCAL_ROWS").ok().and_then(|rows| rows.parse().ok()).unwrap_or(1_000_000);
    let folder = tempfile::tempdir().expect("a folder");
    let with_effects =
        Document::parse(&testkit::read_fixture("correct/flight/input.json")).expect("a document");
    let without = Document { model: None, ..with_effects.clone() };
    for format in ["parquet", "csv"] {
        let path = |name: &str| folder.path().join(format!("{name}.{format}"));
        let readings = path("readings");
        make(&readings, rows);
        let fields = path("fields");
        let correct = |calibration: &Document| {
            let request =
                Request { input: Some(&readings), output: Some(&fields), ..Request::of(calibration) };
            correct_table(&request).expect("corrected");
        };
        let plain = fastest(|| correct(&without));
        let effects = fastest(|| correct(&with_effects));
        // Reading and writing twelve columns; `correct` reads five of them and writes twelve.
        let moved = fastest(|| copy(&fields, &path("copy")));
        println!(
            "{rows} rows of {format}: reading and writing {moved:.2} s; correct {plain:.2} s ({:.1} times), with three effects {effects:.2} s ({:.1} times)",
            plain / moved,
            effects / moved
        );
    }
}

/// Seconds of the fastest of three runs.
fn fastest(run: impl Fn()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..3).map(time).fold(f64::INFINITY, f64::min)
}

fn make(path: &Path, rows: usize) {
    let names = ["time_s", "sensor_temperature_c", "sensor_x_v", "sensor_y_v", "sensor_z_v"];
    let mut writer = Writer::create(path, &names).expect("a table");
    let series: [fn(f64) -> f64; 5] = [
        |t| t,
        |t| 23.0 + 4.0 * (t / 900.0).sin(),
        |t| 7.0 * (t / 31.0).sin(),
        |t| 6.0 * (t / 43.0).cos(),
        |t| 5.0 + (t / 29.0).sin(),
    ];
    for from in (0..rows).step_by(1 << 16) {
        let piece = from..(from + (1 << 16)).min(rows);
        let columns: Vec<Vec<f64>> =
            series.iter().map(|f| piece.clone().map(|row| f(row as f64)).collect()).collect();
        writer.write(&columns).expect("written");
    }
    writer.finish().expect("finished");
}

/// Reads a table and writes it again.
fn copy(fields: &Path, to: &Path) {
    let reader = Reader::open(fields, None).expect("a table");
    let names: Vec<String> = reader.columns().to_vec();
    let mut writer =
        Writer::create(to, &names.iter().map(String::as_str).collect::<Vec<_>>()).expect("a table");
    for batch in reader {
        writer.write(&batch.expect("a batch").columns).expect("written");
    }
    writer.finish().expect("finished");
}
