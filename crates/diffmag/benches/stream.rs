//! Speed of long series.
//!
//! On one core, in memory: one pass over a day at 16 Hz of both instruments in batches of 65 536 rows. The
//! peer reads the same columns and adds them up. Time per row is the time shown over 1 382 400.
//!
//! From files, on all cores: ten million rows of a time and six readings as CSV and as Parquet, each way in a
//! process of its own, so that its peak of memory can be told. The peers: the file read and parsed alone, its
//! bytes alone, and pandas with NumPy's `lstsq`, which find η only (FLUXCAL_PYTHON names another interpreter
//! than python3, FLUXCAL_BENCH_ROWS fewer rows).

use common::Axis;
use diffmag::stream::{Partial, Statistics, answer};
use divan::{Bencher, black_box};
use noise::Stream;
use partial::Take;
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;
use std::time::Instant;
use std::{env, fs};
use tables::{BATCH_ROWS, Reader, Writer};

const ROWS: usize = 1_382_400;
const BATCH: usize = 65_536;

/// Rows of the files.
const FILE_ROWS: usize = 10_000_000;
const FORMATS: [&str; 2] = ["parquet", "csv"];
const NAMES: [&str; 7] =
    ["time_s", "reference_x_nt", "reference_y_nt", "reference_z_nt", "test_x_nt", "test_y_nt", "test_z_nt"];
/// Each way runs so often; the fastest counts.
const RUNS: usize = 3;
/// The word before a way and a file: this process does only that.
const ALONE: &str = "--alone";

fn main() {
    let arguments: Vec<String> = env::args().skip(1).collect();
    if let [word, way, file] = arguments.as_slice()
        && word == ALONE
    {
        return println!("{}", alone(way, Path::new(file)));
    }
    divan::main();
    // Files only where nothing else is asked for.
    if arguments.iter().all(|word| word == "--bench") {
        files();
    }
}

static DAY: LazyLock<(Vec<f64>, [Vec<f64>; 6])> = LazyLock::new(|| {
    let mut stream = Stream::new(1, "day");
    let field = [20_000.0, 500.0, 45_000.0].map(|main| {
        let natural = noise::power_law(&mut stream, ROWS, 0.0625, 2e-4, 1.6);
        natural.into_iter().map(|n| main + n).collect::<Vec<f64>>()
    });
    let test =
        field.each_ref().map(|column| column.iter().map(|b| 1.001 * b + 0.01 * stream.normal()).collect());
    let [x, y, z] = field;
    let [u, v, w] = test;
    ((0..ROWS).map(|row| row as f64 * 0.0625).collect(), [x, y, z, u, v, w])
});

fn pass() -> Partial {
    let (time, columns) = &*DAY;
    let mut statistics = Statistics::default();
    for from in (0..ROWS).step_by(BATCH) {
        let rows = from..(from + BATCH).min(ROWS);
        let batch: Vec<&[f64]> =
            std::iter::once(time).chain(columns).map(|column| &column[rows.clone()]).collect();
        statistics.push(black_box(&batch)).expect("on the grid");
    }
    statistics.finish().expect("a piece")
}

#[divan::bench(sample_count = 10)]
fn one_pass(bencher: Bencher) {
    LazyLock::force(&DAY);
    bencher.bench_local(pass);
}

#[divan::bench(sample_count = 10)]
fn one_pass_peer_sums(bencher: Bencher) {
    let (time, columns) = &*DAY;
    bencher.bench_local(|| {
        columns.iter().chain([time]).map(|column| black_box(column).iter().sum::<f64>()).sum::<f64>()
    });
}

#[divan::bench(sample_count = 10)]
fn the_answer(bencher: Bencher) {
    let partial = pass();
    bencher.bench_local(|| answer(black_box(&partial)).expect("an answer"));
}

/// Writes the same rows in every format: a field that wanders by hundreds of nT, the test instrument turned
/// by some degrees, with three decimals as instruments write them.
fn write(folder: &Path, count: usize) {
    let mut writers = FORMATS
        .map(|format| Writer::create(&folder.join(format!("pair.{format}")), &NAMES).expect("created"));
    let eta = [[0.998, 0.05, -0.011], [-0.05, 1.001, 0.02], [0.012, -0.018, 1.002]];
    let mut stream = Stream::new(3, "files");
    let mut field = [20_000.0, 500.0, 45_000.0];
    for first in (0..count).step_by(BATCH_ROWS) {
        let mut columns = vec![Vec::with_capacity(BATCH_ROWS); NAMES.len()];
        for row in first..count.min(first + BATCH_ROWS) {
            columns[0].push(row as f64);
            field.iter_mut().for_each(|b| *b += 0.1 * stream.normal());
            for k in 0..3 {
                let turned: f64 = (0..3).map(|i| field[i] * eta[i][k]).sum();
                columns[1 + k].push((1e3 * field[k]).round() / 1e3);
                columns[4 + k].push((1e3 * (turned + 12.0 + 0.02 * stream.normal())).round() / 1e3);
            }
        }
        writers.iter_mut().for_each(|writer| writer.write(&columns).expect("written"));
    }
    writers.into_iter().for_each(|writer| writer.finish().expect("finished"));
}

/// One way through one file: seconds, peak of memory, and what it found.
fn alone(way: &str, file: &Path) -> Value {
    let start = Instant::now();
    let found = match way {
        "stream" => {
            let piece = partial::take(&diffmag::Columns::default(), file).expect("a piece");
            let fit = answer(&piece).expect("an answer").fit.expect("a fit");
            let eta = |from| Axis::ALL.map(|to| fit.elements[&format!("{from}{to}")].least_squares);
            json!({"matrix": Axis::ALL.map(eta), "rms_nt": fit.axes.iter().map(|(_, of)| of.rms_nt).collect::<Vec<_>>()})
        }
        "read" => {
            let reader = Reader::open(file, Some(&NAMES)).expect("opened");
            json!({"rows": reader.map(|batch| black_box(batch.expect("a batch")).rows()).sum::<usize>()})
        }
        "bytes" => {
            let mut input = fs::File::open(file).expect("opened");
            json!({"bytes": std::io::copy(&mut input, &mut std::io::sink()).expect("read")})
        }
        other => panic!("no way {other}"),
    };
    json!({"seconds": start.elapsed().as_secs_f64(), "peak_kb": peak_kb(), "found": found})
}

/// The most memory that this process held, as Linux tells it.
fn peak_kb() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.split_whitespace().next()?.parse().ok()
}

/// The fastest of some runs of a command that prints JSON; the reason where it fails.
fn fastest(command: &mut Command) -> Result<Value, String> {
    let mut best: Option<Value> = None;
    for _ in 0..RUNS {
        let output = command.output().map_err(|error| error.to_string())?;
        let said = String::from_utf8_lossy(&output.stderr);
        if !output.status.success() {
            return Err(said.lines().last().unwrap_or("it said nothing").to_string());
        }
        let run: Value = serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())?;
        if best.as_ref().is_none_or(|best| run["seconds"].as_f64() < best["seconds"].as_f64()) {
            best = Some(run);
        }
    }
    best.ok_or_else(|| "no run".into())
}

fn line(name: &str, run: &Value, stream: f64) {
    let seconds = run["seconds"].as_f64().expect("seconds");
    let peak = run["peak_kb"].as_u64().map_or("unknown".into(), |kb| format!("{:.0} MB", kb as f64 / 1e3));
    println!(
        "  {name:<22} {seconds:>8.3} s   peak {peak:>8}   stream takes {:.2} of its time",
        stream / seconds
    );
}

/// The largest difference of two matrices.
fn apart(a: &Value, b: &Value) -> f64 {
    let numbers = |value: &Value| -> Vec<f64> {
        let rows = value.as_array().into_iter().flatten();
        rows.flat_map(|row| row.as_array().into_iter().flatten()).filter_map(Value::as_f64).collect()
    };
    numbers(a).iter().zip(numbers(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn files() {
    let count = env::var("FLUXCAL_BENCH_ROWS").ok().and_then(|text| text.parse().ok()).unwrap_or(FILE_ROWS);
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), count);
    let python = env::var("FLUXCAL_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/stream_peer.py");
    let program = env::current_exe().expect("this program");
    for format in FORMATS {
        let file = folder.path().join(format!("pair.{format}"));
        let size = fs::metadata(&file).expect("a file").len() as f64 / 1e6;
        println!("\n{count} rows as {format}, {size:.0} MB; the fastest of {RUNS}");
        let own = |way: &str| {
            let run = fastest(Command::new(&program).args([ALONE, way]).arg(&file));
            run.unwrap_or_else(|reason| panic!("{way}: {reason}"))
        };
        let stream = own("stream");
        let seconds = stream["seconds"].as_f64().expect("seconds");
        line("diffmag stream", &stream, seconds);
        line("read and parsed alone", &own("read"), seconds);
        line("bytes alone", &own("bytes"), seconds);
        match fastest(Command::new(&python).arg(&script).arg(&file)) {
            Ok(peer) => {
                line("pandas, NumPy lstsq", &peer, seconds);
                let difference = apart(&stream["found"]["matrix"], &peer["matrix"]);
                println!("  largest difference of an element of the matrix: {difference:.1e}");
            }
            Err(reason) => {
                println!("  pandas, NumPy lstsq: the peer is missing, no ratio ({python}: {reason})")
            }
        }
    }
}
