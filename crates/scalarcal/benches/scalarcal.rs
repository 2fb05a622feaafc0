//! Speed against SciPy's `least_squares`, whole processes on the same rows; how far their answers differ.
//!
//! Rows are 10⁴ and 10⁶ in Parquet, turned in all directions, with white noise of 10 ppm. scalarcal reads
//! them beside a document, where the noise is declared white and where it is not, and as a stream. SciPy is
//! told with and without starting Python and reading the file (FLUXCAL_PYTHON names an interpreter).

#[path = "../tests/it/build.rs"]
#[expect(dead_code, reason = "the tests use more of it")]
mod build;

use build::{Campaign, declared};
use common::{Columns, to_text};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::time::Instant;
use std::{env, fs};
use tables::{BATCH_ROWS, Writer};

const ROWS: [usize; 2] = [10_000, 1_000_000];
const NAMES: [&str; 5] = ["time_s", "sensor_x_v", "sensor_y_v", "sensor_z_v", "reference_nt"];
/// Each way runs so often; the fastest counts.
const RUNS: usize = 5;

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    for rows in ROWS {
        write(folder.path(), rows);
        compare(folder.path(), rows);
    }
}

/// The rows, and documents beside them.
fn write(folder: &Path, rows: usize) {
    let mut document = Campaign { rows, ..Campaign::default() }.document(5);
    let recording = &mut document.recordings[0];
    let columns = NAMES.map(|name| recording.column(name).expect("a column"));
    let mut writer = Writer::create(&folder.join("rows.parquet"), &NAMES).expect("created");
    for from in (0..rows).step_by(BATCH_ROWS) {
        let to = rows.min(from + BATCH_ROWS);
        writer.write(&columns.map(|column| column[from..to].to_vec())).expect("written");
    }
    writer.finish().expect("finished");
    recording.columns = Columns::new();
    recording.table = Some("rows.parquet".into());
    for (name, document) in [("open", document.clone()), ("white", declared(document, 0.5))] {
        fs::write(folder.join(format!("{name}.json")), to_text(&document)).expect("written");
    }
}

/// Seconds of the fastest run, and what it wrote; the reason where it fails.
fn fastest(command: &mut Command) -> Result<(f64, Value), String> {
    let mut best: Option<(f64, Value)> = None;
    for _ in 0..RUNS {
        let start = Instant::now();
        let output = command.output().map_err(|error| error.to_string())?;
        let seconds = start.elapsed().as_secs_f64();
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            return Err(said.lines().last().unwrap_or("it said nothing").to_string());
        }
        if best.as_ref().is_none_or(|(before, _)| seconds < *before) {
            best =
                Some((seconds, serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())?));
        }
    }
    best.ok_or_else(|| "no run".into())
}

fn compare(folder: &Path, rows: usize) {
    let python = env::var("FLUXCAL_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/scipy_peer.py");
    println!("\n{rows} rows; the fastest of {RUNS}");
    let peer = fastest(Command::new(&python).arg(&script).arg(folder.join("rows.parquet")));
    match &peer {
        Ok((whole, peer)) => {
            println!("  {:<36} {whole:>8.4} s", "SciPy, whole process");
            println!(
                "  {:<36} {:>8.4} s",
                "SciPy, least_squares alone",
                peer["fit"].as_f64().expect("seconds")
            );
        }
        Err(reason) => println!("  SciPy: the peer is missing, no ratio ({python}: {reason})"),
    }
    let ways: [(&str, &[&str]); 3] = [
        ("scalarcal stream, declared white", &["stream", "-q", "--document", "white.json", "rows.parquet"]),
        ("scalarcal, declared white", &["-q", "white.json"]),
        ("scalarcal, forms of noise averaged", &["-q", "open.json"]),
    ];
    for (name, arguments) in ways {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scalarcal"));
        let run = fastest(command.args(arguments).current_dir(folder));
        let (seconds, document) = run.unwrap_or_else(|reason| panic!("{name}: {reason}"));
        print!("  {name:<36} {seconds:>8.4} s");
        if let Ok((whole, peer)) = &peer {
            let alone = peer["fit"].as_f64().expect("seconds");
            print!("   {:>5.1} and {:>5.1} times as fast", whole / seconds, alone / seconds);
            print!("   apart by {:.1e} standard uncertainties", apart(&document, peer));
        }
        println!();
    }
}

/// The largest difference of the nine parameters, in SciPy's standard uncertainties.
fn apart(document: &Value, peer: &Value) -> f64 {
    let parameters = document["calibration"]["scalar"]["parameters"].as_array().expect("parameters");
    let number = |value: &Value| value.as_f64().expect("a number");
    let of = |(k, parameter): (usize, &Value)| {
        (number(&parameter["value"]) - number(&peer["value"][k])).abs() / number(&peer["std"][k])
    };
    parameters.iter().enumerate().map(of).fold(0.0, f64::max)
}
