//! Speed of IAGA-2002 and CSV.
//!
//! A million rows read, and read and written as Parquet, against pandas on the same file, each way in a
//! process of its own and the fastest of some runs (FLUXCAL_PYTHON names another interpreter than python3,
//! FLUXCAL_BENCH_ROWS another number of rows).

use common::Document;
use ingest::{Options, Readings};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use std::{env, fs};

const DAY_ROWS: usize = 86_400;
const FILE_ROWS: usize = 1_000_000;
const KINDS: [&str; 2] = ["iaga", "csv"];
/// Each way runs so often; the fastest counts.
const RUNS: usize = 5;
/// The word before a file: this process does only that.
const ALONE: &str = "--alone";

fn main() {
    let arguments: Vec<String> = env::args().skip(1).collect();
    match arguments.as_slice() {
        [word, file] if word == ALONE => println!("{}", alone(Path::new(file))),
        _ => files(),
    }
}

/// A file of seconds from 2024-03-01 on.
fn write(folder: &Path, kind: &str, rows: usize) -> PathBuf {
    let mut text = String::with_capacity(75 * rows);
    if kind == "iaga" {
        for (label, content) in [("Format", "IAGA-2002"), ("IAGA Code", "FLX"), ("Reported", "XYZF")] {
            writeln!(text, " {label:<23}{content:<45}|").expect("written");
        }
        writeln!(text, "DATE       TIME         DOY     FLXX      FLXY      FLXZ      FLXF   |")
            .expect("written");
    } else {
        text.push_str("time,x_nT,y_nT,z_nT,temperature_C\n");
    }
    for row in 0..rows {
        let (day, second) = (row / DAY_ROWS, row % DAY_ROWS);
        let (month, date) = if day < 31 { (3, day + 1) } else { (4, day - 30) };
        let clock = format!("{:02}:{:02}:{:02}", second / 3600, second / 60 % 60, second % 60);
        let angle = row as f64 * 1e-3;
        let (x, y) = (20_900.0 + 90.0 * angle.sin(), 1400.0 + 80.0 * angle.cos());
        let z = 43_800.0 + 9.0 * (2.0 * angle).sin();
        if kind == "iaga" {
            let f = if row % 10 == 0 { 48_552.75 } else { 99_999.0 };
            let of_year = 61 + day;
            let row = format!("{clock}.000 {of_year:03}    {x:9.2} {y:9.2} {z:9.2} {f:9.2}");
            writeln!(text, "2024-{month:02}-{date:02} {row}").expect("written");
        } else {
            let row = format!("{clock}Z,{x:.3},{y:.3},{z:.3},{:.2}", 18.0 + 0.1 * angle.sin());
            writeln!(text, "2024-{month:02}-{date:02}T{row}").expect("written");
        }
    }
    let path = folder.join(format!("{kind}.txt"));
    fs::write(&path, text).expect("written");
    path
}

/// Reads a file, writes its table; the seconds of both and the rows.
fn alone(file: &Path) -> Value {
    let start = Instant::now();
    let name = format!("{}.parquet", file.file_name().expect("a name").to_string_lossy());
    let options = Options { readings: Readings::Beside(Some(name)), ..Options::default() };
    let document = Document { fluxcal: 1, ..Document::default() };
    let ingested = ingest::run(document, &[file.into()], &options).expect("taken");
    let read = start.elapsed().as_secs_f64();
    let table = ingested.table.expect("a table");
    table.write(file.parent().expect("a folder")).expect("written");
    let whole = start.elapsed().as_secs_f64();
    json!({"read": read, "whole": whole, "rows": table.columns[0].1.len()})
}

/// The fastest of some runs, for reading and for the whole; the reason where one fails.
fn fastest(command: &mut Command) -> Result<Value, String> {
    let mut best = json!({"read": f64::INFINITY, "whole": f64::INFINITY});
    for _ in 0..RUNS {
        let output = command.output().map_err(|error| error.to_string())?;
        let said = String::from_utf8_lossy(&output.stderr);
        if !output.status.success() {
            return Err(said.lines().last().unwrap_or("it said nothing").to_string());
        }
        let run: Value = serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())?;
        for key in ["read", "whole"] {
            if best[key].as_f64().is_none_or(|best| run[key].as_f64() < Some(best)) {
                best[key] = run[key].clone();
            }
        }
        best["rows"] = run["rows"].clone();
    }
    Ok(best)
}

fn files() {
    let rows = env::var("FLUXCAL_BENCH_ROWS").ok().and_then(|text| text.parse().ok()).unwrap_or(FILE_ROWS);
    let folder = tempfile::tempdir().expect("a folder");
    let python = env::var("FLUXCAL_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/pandas_peer.py");
    let program = env::current_exe().expect("this program");
    let seconds = |run: &Value, key: &str| run[key].as_f64().expect("seconds");
    for kind in KINDS {
        let file = write(folder.path(), kind, rows);
        let size = fs::metadata(&file).expect("a file").len() as f64 / 1e6;
        println!("\n{rows} rows of {kind}, {size:.0} MB; the fastest of {RUNS}");
        let own = fastest(Command::new(&program).arg(ALONE).arg(&file)).expect("ingest");
        let (read, whole) = (seconds(&own, "read"), seconds(&own, "whole"));
        println!("  {:<24} read {read:.3} s, and written {whole:.3} s", "ingest");
        let peers: &[&str] = if kind == "csv" { &["csv", "csv-pyarrow"] } else { &["iaga"] };
        for peer in peers {
            match fastest(Command::new(&python).arg(&script).arg(peer).arg(&file)) {
                Ok(run) => {
                    let (peer_read, peer_whole) = (seconds(&run, "read"), seconds(&run, "whole"));
                    println!(
                        "  {:<24} read {peer_read:.3} s, and written {peer_whole:.3} s: {:.1} and {:.1} times ingest's",
                        format!("pandas ({peer})"),
                        peer_read / read,
                        peer_whole / whole
                    );
                    assert_eq!(run["rows"], own["rows"]);
                }
                Err(reason) => println!("  pandas ({peer}): no ratio ({python}: {reason})"),
            }
        }
    }
}
