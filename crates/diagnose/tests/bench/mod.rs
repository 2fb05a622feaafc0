//! Documents with known physics left out.

use common::{AdoptedEffect, Document, Quantity};
use serde_json::{Value, json};
use simulate::Campaign;

/// Rms of the noise of a reading that every document declares, nT.
pub const NOISE_NT: f64 = 0.3;

/// What is recorded.
#[derive(Clone, Copy, PartialEq)]
#[allow(dead_code, reason = "each test uses some")]
pub enum Plan {
    /// Three runs in different orientations: sines on all coils, temperatures up and down.
    Runs,
    /// Readings 500 times a second, the coils held.
    Fast,
}

/// A plan in which `effects` are true and not stated, with a seed for the noise.
pub fn plan(which: Plan, effects: &Value, seed: u64, noise: &Value) -> Value {
    let rows = if which == Plan::Runs { 160 } else { 400 };
    let step = if which == Plan::Runs { 10.0 } else { 0.002 };
    let orientations = [
        json!([[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        json!([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        json!([[0, 0, -1], [0, 1, 0], [1, 0, 0]]),
    ];
    let runs = if which == Plan::Runs { 3 } else { 1 };
    let procedures: Vec<Value> = (0..runs)
        .map(|run| {
            let time: Vec<f64> = (0..rows).map(|row| step * f64::from(run * (rows + 30) + row)).collect();
            let wave = |period: f64, phase: f64, size: f64| -> Vec<f64> {
                let held = if which == Plan::Runs { 1.0 } else { 0.0 };
                time.iter().map(|t| size * (held * std::f64::consts::TAU * t / period + phase).sin()).collect()
            };
            let warm = |level: f64, a: f64, p: f64, b: f64, q: f64| -> Vec<f64> {
                wave(p, 0.3, a).iter().zip(wave(q, 1.1, b)).map(|(u, v)| level + u + v).collect()
            };
            json!({"procedure": "free_run", "id": format!("run-{}", run + 1),
                "conditions": {"orientation": orientations[run as usize]},
                "columns": {"time_s": time, "coil_x_a": wave(610.0, 0.4, 1.0), "coil_y_a": wave(430.0, 1.3, 1.0),
                    "coil_z_a": wave(790.0, 2.2, 1.0),
                    "sensor_temperature_c": warm(23.0, 8.0, 3100.0, 2.0, 900.0),
                    "electronics_temperature_c": warm(26.0, 5.0, 1900.0, 2.0, 700.0),
                    "panel_current_a": warm(1.5, 1.0, 333.0, 0.6, 1250.0)}})
        })
        .collect();
    json!({"fluxcal": 1, "title": "diagnose", "seed": seed,
        "facility": {"coils": {"x": {"max_nt": 60000}, "y": {"max_nt": 60000}, "z": {"max_nt": 60000}}},
        "instrument": {"range_nt": 80000, "noise": noise},
        "calibration": {
            "coils": {"x": {"constant_nt_per_a": 30000.0, "offset_nt": 0.0}, "y": {"constant_nt_per_a": 30000.0, "offset_nt": 0.0},
                "z": {"constant_nt_per_a": 30000.0, "offset_nt": 0.0}},
            "sensors": {"x": {"sensitivity_nt_per_nt": 1.0, "offset_nt": 3.0}, "y": {"sensitivity_nt_per_nt": 1.001, "offset_nt": -2.0},
                "z": {"sensitivity_nt_per_nt": 0.999, "offset_nt": 1.0}},
            "axes": {"sensors": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}, "coils": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}},
            "reference_conditions": {"sensor_temperature_c": 23.0, "electronics_temperature_c": 26.0, "coil_temperature_c": 21.0}},
        "truth": {"model": {"effects": effects}}, "procedures": procedures})
}

/// Declared noise: white and a little flicker, together [`NOISE_NT`] of a reading.
pub fn noise() -> Value {
    json!({"white_rms_nt": 0.27, "flicker_nt2_per_hz_at_1hz": 0.006, "flicker_exponent": 1.0})
}

/// The recordings of a plan.
pub fn simulated(plan: &Value) -> Document {
    let plan: simulate::Plan = common::parse(&plan.to_string()).expect("a plan");
    let Campaign { document, .. } = simulate::campaign(&plan).expect("simulated");
    document
}

/// An effect scaled so that it makes `times` the noise in the channels that it touches; with what it is then.
#[allow(dead_code, reason = "each test uses some")]
pub fn scaled(which: Plan, effect: &Value, times: f64) -> Value {
    let none = json!({});
    let without = simulated(&plan(which, &json!([]), 1, &none));
    let with = simulated(&plan(which, &json!([effect]), 1, &none));
    let (mut largest, mut count) = (0.0_f64, 0);
    for axis in ["x", "y", "z"] {
        let mut sum = 0.0;
        let mut values = Vec::new();
        for (a, b) in without.recordings.iter().zip(&with.recordings) {
            let name = format!("sensor_{axis}_nt");
            let name = if a.columns.contains_key(&name) { name } else { format!("sensor_{axis}_v") };
            values.extend(a.columns[&name].0.iter().zip(&b.columns[&name].0).map(|(a, b)| b - a));
        }
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        sum += values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / values.len() as f64;
        largest = largest.max(sum.sqrt());
        count += values.len();
    }
    assert!(largest > 0.0 && count > 0);
    let factor = times * NOISE_NT / largest;
    let mut scaled = effect.clone();
    let kind = physics::Kind::named(effect["effect"].as_str().expect("a name")).expect("an effect");
    let no_amplitude = kind.parameters().iter().all(|info| info.role != physics::Role::Amplitude);
    for info in kind.parameters() {
        let moves = info.role == physics::Role::Amplitude || (no_amplitude && info.role == physics::Role::Shape);
        if moves {
            let value = effect["parameters"][info.name].as_f64().expect("a number");
            scaled["parameters"][info.name] = json!(value * factor);
        }
    }
    scaled
}

/// The name of an effect with its target.
#[allow(dead_code, reason = "each test uses some")]
pub fn named(effect: &AdoptedEffect) -> String {
    let axis = effect.sensor.or(effect.coil).map(|axis| axis.to_string());
    axis.or_else(|| effect.column.clone())
        .map_or_else(|| effect.effect.clone(), |target| format!("{} {target}", effect.effect))
}

/// By how many standard deviations parameters differ from what is true, at most.
#[allow(dead_code, reason = "each test uses some")]
pub fn worst_sigma(found: &indexmap::IndexMap<String, Quantity>, truth: &Value) -> f64 {
    found
        .iter()
        .filter_map(|(name, value)| {
            let std = value.std().filter(|std| *std > 0.0)?;
            Some((value.value() - truth["parameters"][name].as_f64()?).abs() / std)
        })
        .fold(0.0, f64::max)
}
