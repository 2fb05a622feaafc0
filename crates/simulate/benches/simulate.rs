//! Speed, as ratios against a peer in the same run.
//!
//! `campaign` is 10⁷ samples of three channels with five effects and flicker noise; its peer writes 3 · 10⁷
//! normal numbers from one stream, which is the least that any noise costs. `text` is the JSON of a tenth of
//! it, its peer the formatting of the same numbers one by one.

use divan::{Bencher, black_box};
use serde_json::json;
use std::fmt::Write;

const ROWS: usize = 10_000_000;

fn main() {
    divan::main();
}

fn plan(rows: usize) -> simulate::Plan {
    let mut plan = simulate::Plan::parse(
        &json!({
            "fluxcal": 1,
            "instrument": {"noise": {"white_rms_nt": 0.1, "flicker_nt2_per_hz_at_1hz": 1e-4}, "quantisation_nt": 0.01},
            "calibration": {
                "coils": {"x": {"constant_nt_per_a": 40000.0}, "y": {"constant_nt_per_a": 41000.0}, "z": {"constant_nt_per_a": 42000.0}},
                "reference_conditions": {"sensor_temperature_c": 20.0}},
            "truth": {"model": {"effects": [
                {"effect": "coil_heating", "coil": "z", "parameters": {"fall_ppm_per_a2": 50, "lag_s": 900}},
                {"effect": "eddy_currents", "coil": "x", "parameters": {"share_ppm": 800, "time_constant_s": 0.4}},
                {"effect": "offset_temperature_lag", "sensor": "x", "parameters": {"coefficient_nt_per_k": 0.5, "lag_s": 600}},
                {"effect": "cross_field", "sensor": "y", "parameters": {"first_nt": 2, "second_nt": 3, "mixed_nt": 1}},
                {"effect": "loop_bandwidth", "sensor": "z", "parameters": {"lag_s": 0.05}}]}},
            "procedures": [{"procedure": "free_run", "id": "run", "columns": {"time_s": [0.0]}}]
        })
        .to_string(),
    )
    .expect("a plan");
    let time: Vec<f64> = (0..rows).map(|row| row as f64 * 0.01).collect();
    let sine = |amplitude: f64, period: f64| time.iter().map(|t| amplitude * (t / period).sin()).collect();
    if let simulate::Procedure::FreeRun(run) = &mut plan.procedures[0] {
        run.columns = [
            ("coil_x_a", sine(1.0, 11.0)),
            ("coil_y_a", sine(0.8, 17.0)),
            ("coil_z_a", sine(1.2, 29.0)),
            ("sensor_temperature_c", sine(5.0, 4000.0)),
            ("time_s", common::Column::from(time.clone())),
        ]
        .map(|(name, column)| (name.to_string(), column))
        .into_iter()
        .collect();
    }
    plan
}

#[divan::bench(sample_count = 3)]
fn campaign(bencher: Bencher) {
    let plan = plan(ROWS);
    bencher.bench_local(|| simulate::campaign(black_box(&plan)).expect("simulated"));
}

#[divan::bench(sample_count = 3)]
fn campaign_peer_normal_numbers(bencher: Bencher) {
    bencher.bench_local(|| {
        let mut stream = noise::Stream::new(black_box(1), "peer");
        (0..3 * ROWS).map(|_| stream.normal()).collect::<Vec<f64>>()
    });
}

#[divan::bench(sample_count = 3)]
fn text(bencher: Bencher) {
    let document = simulate::campaign(&plan(ROWS / 10)).expect("simulated").document;
    bencher.bench_local(|| common::to_text(black_box(&document)));
}

#[divan::bench(sample_count = 3)]
fn text_peer_formatting(bencher: Bencher) {
    let document = simulate::campaign(&plan(ROWS / 10)).expect("simulated").document;
    bencher.bench_local(|| {
        let mut text = String::new();
        for value in document.recordings.iter().flat_map(|recording| recording.columns.values()).flatten() {
            write!(text, "{value}, ").expect("memory");
        }
        text
    });
}
