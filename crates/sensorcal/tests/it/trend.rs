//! Coverage of trend and yearly term of weekly offsets that wander (FLUXCAL_CAMPAIGNS campaigns).

use common::{Axis, OffsetDrift};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::build;

const DATES: usize = 53;
const WEEK_S: f64 = 604_800.0;
const PAIRS: usize = 6;
const WHITE_NT: f64 = 0.1;

/// Weekly offsets of sensor x, each of six pairs under white noise that is declared.
fn drift(wander: &Value, seed: u64) -> OffsetDrift {
    let plan = json!({
        "fluxcal": 1,
        "seed": seed,
        "start": "2026-03-02T08:00:00Z",
        "instrument": {"sensors": ["x"], "nominal_sensitivity_nt_per_v": 6400, "noise": {"white_rms_nt": WHITE_NT}},
        "calibration": {"sensors": {"x": {"sensitivity_nt_per_v": 6400.0, "offset_nt": 0.0}}},
        "truth": {"shield_field_nt": {"x": 2.1, "y": -1.4, "z": 3.2}, "offset_wander": wander},
        "procedures": [{"procedure": "offset_drift", "id": "drift", "pairs": PAIRS, "dates": DATES}]
    });
    let found = build::calibrated(build::simulated(&plan).document);
    *build::of(&found, Axis::X).drift.clone().expect("a drift")
}

/// Whether the intervals of trend, cosine and sine hold zero, in each of the campaigns.
fn covered(wander: &Value) -> [Vec<bool>; 3] {
    let held = |seed: u64| {
        let drift = drift(wander, seed);
        let annual = drift.annual.expect("a yearly term");
        let trend = drift.trend_nt_per_year.expect("a trend");
        [trend, annual.cosine_nt, annual.sine_nt].map(|quantity| {
            let half = quantity.coverage_factor_95().expect("a factor") * quantity.std().expect("a std");
            quantity.value().abs() <= half
        })
    };
    let all: Vec<[bool; 3]> = (0..testkit::campaigns(40)).into_par_iter().map(held).collect();
    [0, 1, 2].map(|which| all.iter().map(|held| held[which]).collect())
}

/// The interval says "at least": 93 % or more, and no more than 97 % where a random walk is seen.
#[test]
fn trend_and_year_cover_whatever_wanders() {
    let own = WHITE_NT * WHITE_NT / (2 * PAIRS) as f64;
    let span_s = WEEK_S * (DATES - 1) as f64;
    // Mean variance over the dates r² T/2, as a multiple of that of a date's own error.
    let walk = |ratio: f64| json!({"random_walk_nt_per_sqrt_s": (2.0 * ratio * own / span_s).sqrt()});
    // Σ A/f Δf over the 26 frequencies of 53 dates, which is A Σ 1/k.
    let harmonic: f64 = (1..=DATES / 2).map(|k| 1.0 / k as f64).sum();
    let flicker = |ratio: f64| json!({"flicker_nt2_per_hz_at_1hz": ratio * own / harmonic});
    let cases = [
        ("none", json!({"white_rms_nt": 0.0}), 1.0),
        ("white noise of 4", json!({"white_rms_nt": (4.0 * own).sqrt()}), 1.0),
        ("flicker noise of 16", flicker(16.0), 1.0),
        ("a random walk of 1", walk(1.0), 1.0),
        ("a random walk of 4", walk(4.0), 1.0),
        ("a random walk of 16", walk(16.0), 0.97),
        ("a random walk of 256", walk(256.0), 0.97),
    ];
    let (mut outside, judged) = (Vec::new(), 3 * cases.len());
    for (name, wander, most) in cases {
        for (term, held) in ["trend", "cosine", "sine"].iter().zip(covered(&wander)) {
            outside.extend(build::outside(&format!("{name}: {term}"), &held, [0.93, most], judged));
        }
    }
    assert!(outside.is_empty(), "{}", outside.join("; "));
}

#[test]
fn a_random_walk_that_is_not_seen_is_said() {
    let still = drift(&json!({"white_rms_nt": 0.0}), 3);
    let said = |drift: &OffsetDrift| {
        drift.findings.iter().any(|finding| finding.contains("neither establish nor exclude a random walk"))
    };
    assert!(said(&still), "{:?}", still.findings);
    let walking = drift(&json!({"random_walk_nt_per_sqrt_s": 1e-4}), 3);
    assert!(!said(&walking) && walking.noise["random_walk"] > 0.9, "{walking:?}");
}
