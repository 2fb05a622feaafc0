//! Speed of reading, as ratios against peers in the same run.
//!
//! A million rows of seven columns (a time and two sensors of three axes), from CSV, NDJSON and Parquet. The
//! peers: the bytes of each file alone, and the `csv` crate with `str::parse`.

use divan::{Bencher, black_box};
use std::fs;
use std::path::PathBuf;
use std::sync::{LazyLock, Mutex};
use tables::{BATCH_ROWS, Reader, Writer};
use tempfile::TempDir;

const ROWS: usize = 1_000_000;
const FORMATS: [&str; 3] = ["csv", "ndjson", "parquet"];
const NAMES: [&str; 7] =
    ["time_s", "reference_x_nt", "reference_y_nt", "reference_z_nt", "test_x_nt", "test_y_nt", "test_z_nt"];

fn main() {
    divan::main();
    drop(FOLDER.lock().expect("free").take());
}

/// Removed at the end of `main`: statics are not dropped.
static FOLDER: Mutex<Option<TempDir>> = Mutex::new(None);

static FILES: LazyLock<[PathBuf; 3]> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder");
    let files = FORMATS.map(|format| folder.path().join(format!("pair.{format}")));
    for file in &files {
        let mut writer = Writer::create(file, &NAMES).expect("created");
        for first in (0..ROWS).step_by(BATCH_ROWS) {
            writer.write(&rows(first, ROWS.min(first + BATCH_ROWS))).expect("written");
        }
        writer.finish().expect("finished");
    }
    *FOLDER.lock().expect("free") = Some(folder);
    files
});

/// A field of tens of µT that varies by 100 nT, with two decimals.
fn rows(start: usize, end: usize) -> Vec<Vec<f64>> {
    let column = |column: usize| {
        let value = |row: usize| match column {
            0 => row as f64 * 0.01,
            _ => (1e6 * column as f64 + 1e4 * (row as f64 * 1e-3 * column as f64).sin()).round() / 100.0,
        };
        (start..end).map(value).collect()
    };
    (0..NAMES.len()).map(column).collect()
}

fn file(format: &str) -> &'static PathBuf {
    let place = FORMATS.iter().position(|name| *name == format).expect("a format");
    &FILES[place]
}

#[divan::bench(args = FORMATS, sample_count = 10)]
fn read(bencher: Bencher, format: &str) {
    let path = file(format);
    bencher.bench_local(|| {
        let reader = Reader::open(black_box(path), None).expect("opened");
        reader.map(|batch| black_box(batch.expect("a batch")).rows()).sum::<usize>()
    });
}

#[divan::bench(args = FORMATS, sample_count = 10)]
fn read_two_columns(bencher: Bencher, format: &str) {
    let path = file(format);
    bencher.bench_local(|| {
        let reader = Reader::open(black_box(path), Some(&["time_s", "test_z_nt"])).expect("opened");
        reader.map(|batch| black_box(batch.expect("a batch")).rows()).sum::<usize>()
    });
}

#[divan::bench(args = FORMATS, sample_count = 10)]
fn peer_bytes_alone(bencher: Bencher, format: &str) {
    let path = file(format);
    bencher.bench_local(|| fs::read(black_box(path)).expect("read"));
}

#[divan::bench(sample_count = 10)]
fn peer_csv_crate(bencher: Bencher) {
    let path = file("csv");
    bencher.bench_local(|| {
        let mut columns = vec![Vec::new(); NAMES.len()];
        let mut reader = csv::Reader::from_path(black_box(path)).expect("opened");
        let mut record = csv::StringRecord::new();
        while reader.read_record(&mut record).expect("a record") {
            for (column, field) in columns.iter_mut().zip(&record) {
                column.push(field.parse::<f64>().expect("a number"));
            }
        }
        columns
    });
}
