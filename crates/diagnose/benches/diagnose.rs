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
        println!("\n{} rows of 3 sensors: {}; the fastest of {RUNS}", times * SMALL, whole.found);
        println!("  diagnose            {:>8.3} s   peak {:>6.0} MB", whole.seconds, whole.peak_mb);
        println!("  products of a pool  {:>8.3} s   peak {:>6.0} MB", peer.seconds, peer.peak_mb);
        println!("  diagnose takes {:.1} times as long as its peer", whole.seconds / peer.seconds);
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
            (
                start.elapsed().as_secs_f64(),
                diagnose::summary(&document).lines().nth(2).unwrap_or_default().trim().to_string(),
            )
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

/// What one way took.
struct Run {
    seconds: f64,
    peak_mb: f64,
    found: String,
}

/// The fastest of some runs.
fn fastest(way: &str, times: usize) -> Run {
    let program = env::current_exe().expect("this program");
    let once = || {
        let output = Command::new(&program).args([ALONE, way, &times.to_string()]).output().expect("a run");
        let text = String::from_utf8_lossy(&output.stdout);
        let said: Value = serde_json::from_str(&text)
            .unwrap_or_else(|_| panic!("{way} failed: {}", String::from_utf8_lossy(&output.stderr)));
        let number = |name: &str| said[name].as_f64().unwrap_or(f64::NAN);
        Run {
            seconds: number("seconds"),
            peak_mb: number("peak_mb"),
            found: said["found"].as_str().unwrap_or_default().into(),
        }
    };
    (0..RUNS).map(|_| once()).min_by(|a, b| a.seconds.total_cmp(&b.seconds)).expect("a run")
}
