//! Documents of the public format, written from its page and not through the stages' types.

use nalgebra::Matrix3;
use serde_json::{Map, Value, json};

use crate::draw::Draw;
use crate::noise::Noise;
use crate::scene::{AXES, Bench, Campaign, Readings, Run, World};
use crate::scenes::quaternion;

/// Standard uncertainties of the earlier calibration: relative ones of constants, nT of offsets, arcsec of
/// axes.
const CONSTANT: f64 = 1e-5;
const OFFSET_NT: f64 = 0.3;
const AXIS_ARCSEC: f64 = 2.0;

/// The document of a campaign: what an earlier, honest calibration found (the truth and an error of the
/// stated size), the declared noise, and the recordings.
pub fn of(campaign: &Campaign, noise: Noise, readings: &Readings, title: &str, draw: &mut Draw) -> Value {
    let recordings: Vec<Value> = campaign
        .runs
        .iter()
        .zip(readings)
        .map(|(run, readings)| recording(campaign, run, readings))
        .collect();
    let mut declared = json!({"white_rms_nt": noise.white_nt});
    if noise.flicker_nt2_per_hz > 0.0 {
        declared["flicker_nt2_per_hz_at_1hz"] = json!(noise.flicker_nt2_per_hz);
        declared["flicker_exponent"] = json!(noise.exponent);
    }
    json!({
        "fluxcal": 1,
        "title": title,
        "facility": {"coils": {"x": {"max_nt": 60000}, "y": {"max_nt": 60000}, "z": {"max_nt": 60000}}},
        "instrument": {"range_nt": 80000, "quantisation_nt": campaign.code_nt, "noise": declared,
            "positions_m": {"x": [0.04, 0.0, 0.01], "y": [0.0, 0.05, 0.0], "z": [0.0, 0.01, -0.04]}},
        "calibration": calibration(campaign, draw),
        "recordings": recordings,
    })
}

fn quantity(value: f64, std: f64, draw: &mut Draw) -> Value {
    json!({"value": value + std * draw.normal(), "std": std})
}

fn calibration(campaign: &Campaign, draw: &mut Draw) -> Value {
    let Bench { coil_nt_per_a, eta, mu, sensitivity, offset_nt } = &campaign.bench;
    let [sensor_c, electronics_c, coil_c] = campaign.reference_c;
    let reference = json!({"sensor_temperature_c": sensor_c, "electronics_temperature_c": electronics_c, "coil_temperature_c": coil_c});
    if campaign.runs.iter().any(|run| matches!(run.world, World::Pair(_))) {
        let offsets = keyed(|k| json!(offset_nt[k] + OFFSET_NT * draw.normal()));
        return json!({"differential": {"matrix": rows(&about(eta, draw)), "offset_nt": offsets}, "reference_conditions": reference});
    }
    let sensors = keyed(
        |k| json!({"sensitivity_nt_per_nt": quantity(sensitivity[k], CONSTANT, draw), "offset_nt": quantity(offset_nt[k], OFFSET_NT, draw)}),
    );
    let mut calibration = json!({"sensors": sensors, "reference_conditions": reference,
        "axes": {"sensors": {"matrix": rows(&about(mu, draw)), "std_arcsec": AXIS_ARCSEC}}});
    if campaign.runs.iter().any(|run| matches!(run.world, World::Coils(_))) {
        calibration["coils"] = keyed(|k| {
            let constant = quantity(coil_nt_per_a[k], CONSTANT * coil_nt_per_a[k], draw);
            json!({"constant_nt_per_a": constant, "offset_nt": quantity(0.0, OFFSET_NT, draw)})
        });
        calibration["axes"]["coils"] = json!({"matrix": rows(&about(eta, draw)), "std_arcsec": AXIS_ARCSEC});
    }
    calibration
}

/// A matrix of directions with each of them off by the stated uncertainty, their lengths kept.
fn about(matrix: &Matrix3<f64>, draw: &mut Draw) -> Matrix3<f64> {
    let mut found = *matrix;
    for mut column in found.column_iter_mut() {
        let length = column.norm();
        column.iter_mut().for_each(|part| *part += AXIS_ARCSEC * 4.848e-6 * draw.normal());
        let scale = length / column.norm();
        column *= scale;
    }
    found
}

fn keyed(mut of: impl FnMut(usize) -> Value) -> Value {
    let keys: Map<String, Value> = (0..3).map(|k| (AXES[k].to_string(), of(k))).collect();
    Value::Object(keys)
}

/// A matrix as a list of rows.
pub fn rows(matrix: &Matrix3<f64>) -> Value {
    json!([0, 1, 2].map(|i| [matrix[(i, 0)], matrix[(i, 1)], matrix[(i, 2)]]))
}

/// Values rounded to a unit, as a logger writes them.
pub fn rounded(values: impl Iterator<Item = f64>, unit: f64) -> Value {
    let inverse = (1.0 / unit).round();
    json!(values.map(|value| (value * inverse).round() / inverse).collect::<Vec<f64>>())
}

fn recording(campaign: &Campaign, run: &Run, readings: &[Vec<f64>; 3]) -> Value {
    let mut columns = Map::new();
    columns.insert("time_s".into(), rounded(run.times.iter().copied(), 1e-6));
    let at_times =
        |signal: &crate::signal::Signal, unit: f64| rounded(run.times.iter().map(|t| signal(*t)), unit);
    let mut reading = "sensor";
    match &run.world {
        World::Coils(current) => {
            for (axis, current) in AXES.iter().zip(current) {
                columns.insert(format!("coil_{axis}_a"), at_times(current, 1e-7));
            }
        }
        World::Natural(field) => {
            for (axis, field) in AXES.iter().zip(field) {
                columns.insert(format!("ambient_{axis}_nt"), at_times(field, 1e-3));
            }
        }
        World::Pair(field) => {
            reading = "test";
            for (axis, field) in AXES.iter().zip(field) {
                columns.insert(format!("reference_{axis}_nt"), at_times(field, 1e-3));
            }
        }
    }
    if !run.still {
        let turned: Vec<[f64; 4]> = run.times.iter().map(|t| quaternion(&(run.attitude)(*t))).collect();
        for (k, part) in ["w", "x", "y", "z"].iter().enumerate() {
            columns.insert(format!("attitude_{part}"), rounded(turned.iter().map(|q| q[k]), 1e-12));
        }
    }
    for (sensor, axis) in AXES.iter().enumerate() {
        let values = readings[sensor].iter().map(|value| value / campaign.reading_nt(sensor));
        columns.insert(format!("{reading}_{axis}_nt"), rounded(values, campaign.code_nt));
    }
    let names = ["sensor_temperature_c", "electronics_temperature_c", "coil_temperature_c"];
    for (name, signal) in names.iter().zip(&run.temperatures) {
        if *name != "coil_temperature_c" || run.current(0).is_some() {
            columns.insert((*name).into(), at_times(signal, 1e-3));
        }
    }
    for (name, signal) in &run.columns {
        columns.insert(name.clone(), at_times(signal, if name.ends_with("_rad") { 1e-9 } else { 1e-3 }));
    }
    let procedure = if reading == "test" { "differential" } else { "free_run" };
    let mut recording = json!({"id": run.id, "procedure": procedure, "start": "2026-05-28T00:00:00+00:00", "columns": columns});
    if run.still && reading == "sensor" {
        let start = run.times.first().copied().unwrap_or(0.0);
        recording["conditions"] = json!({"orientation": rows(&(run.attitude)(start))});
    }
    recording
}
