//! Speed of a whole diagnosis, through the library, the document in memory: an offset that follows the
//! temperature with a lag is concealed in three runs, the noise is white and flicker.
//!
//! Each way runs in a process of its own, so that its peak of memory can be told. The peer is the products of
//! 400 columns of as many readings, once and in one piece on one thread. The search needs such products of
//! all its columns in every look, for it projects the base model out of them; all else (prediction,
//! whitening, bootstrap, refits with every rival, readings left out) comes on top. FLUXCAL_BENCH_ROWS asks
//! for other rows than the requirement's.

#[path = "../tests/it/bench.rs"]
#[allow(dead_code, reason = "the tests need more of this than the bench")]
mod scenes;

use faer::Mat;
use scenes::{Scene, noise, simulated};
use serde_json::{Value, json};
use std::hint::black_box;
use std::process::Command;
use std::time::Instant;
use std::{env, fs};

/// Rows of a scene that is not made longer, all runs together.
const SMALL: usize = 480;
/// Rows of the requirement.
const LARGE: usize = 100_000;
/// Columns of the peer.
const COLUMNS: usize = 400;
/// Each way runs so often; the fastest counts.
const RUNS: usize = 3;
/// The word before a way and how many times longer the scene is: this process does only that.
const ALONE: &str = "--alone";

fn main() {
    let arguments: Vec<String> = env::args().skip(1).collect();
    if let [word, way, times] = arguments.as_slice()
        && word == ALONE
    {
        return println!("{}", alone(way, times.parse().expect("a number")));
    }
    let rows = env::var("FLUXCAL_BENCH_ROWS").ok().and_then(|text| text.parse().ok()).unwrap_or(LARGE);
    for times in [1, rows.div_ceil(SMALL)] {
        let [whole, peer] = ["diagnose", "products"].map(|way| fastest(way, times));
        let found = whole["found"].as_str().unwrap_or_default();
        println!("\n{} rows of 3 sensors: {found}; the fastest of {RUNS}", times * SMALL);
        for (name, run) in [("diagnose", &whole), ("products of a pool", &peer)] {
            let (seconds, peak_mb) = (number(run, "seconds"), number(run, "peak_mb"));
            println!("  {name:19} {seconds:>8.3} s   peak {peak_mb:>6.0} MB");
        }
        let ratio = number(&whole, "seconds") / number(&peer, "seconds");
        println!("  diagnose takes {ratio:.1} times as long as its peer");
    }
}

/// One way: seconds, peak of memory, and what it found.
fn alone(way: &str, times: usize) -> Value {
    let (seconds, found) = match way {
        "diagnose" => {
            scenes::longer(times);
            let lag = json!({"effect": "offset_temperature_lag", "sensor": "y", "parameters": {"coefficient_nt_per_k": 0.1, "lag_s": 300.0}});
            let document = simulated(Scene::Runs, &[lag], &noise(), 1);
            let start = Instant::now();
            let document = diagnose::run(document, &diagnose::Options::default()).expect("a diagnosis");
            let seconds = start.elapsed().as_secs_f64();
            (seconds, diagnose::summary(&document).lines().nth(2).unwrap_or_default().trim().to_string())
        }
        "products" => {
            let pool = Mat::from_fn(3 * SMALL * times, COLUMNS, |i, j| ((i * (j + 1)) as f64).sin());
            let start = Instant::now();
            black_box(pool.transpose() * &pool);
            (start.elapsed().as_secs_f64(), String::new())
        }
        other => panic!("no way {other}"),
    };
    json!({"seconds": seconds, "peak_mb": peak_mb(), "found": found})
}

/// The most memory that this process held, as Linux tells it.
fn peak_mb() -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    peak.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok()).map_or(f64::NAN, |kb| kb / 1e3)
}

/// The fastest of some runs.
fn fastest(way: &str, times: usize) -> Value {
    let program = env::current_exe().expect("this program");
    let once = |_| -> Value {
        let output = Command::new(&program).args([ALONE, way, &times.to_string()]).output().expect("a run");
        let failed = || format!("{way} failed: {}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", failed()))
    };
    let runs = (0..RUNS).map(once);
    runs.min_by(|a, b| number(a, "seconds").total_cmp(&number(b, "seconds"))).expect("a run")
}

fn number(run: &Value, name: &str) -> f64 {
    run[name].as_f64().unwrap_or(f64::NAN)
}
