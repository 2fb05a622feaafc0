//! Recordings made by hand, for tests.

use common::{Axis, Document, SensorCalibration};
use noise::Stream;
use serde_json::{Value, json};

/// Coil constant, nT/A.
pub const COIL: f64 = 40_000.0;
/// Sensitivity, nT/V.
pub const K: f64 = 6400.0;

/// A document with three exact coils, an instrument and no recordings.
pub fn bench() -> Value {
    let coil = json!({"constant_nt_per_a": COIL, "offset_nt": 0.0});
    json!({
        "fluxcal": 1,
        "instrument": {"sensors": ["x", "y", "z"], "nominal_sensitivity_nt_per_v": K},
        "calibration": {"coils": {"x": coil, "y": coil, "z": coil}},
        "recordings": []
    })
}

/// Fields from −to to +to.
pub fn sweep(to: f64, steps: usize) -> Vec<f64> {
    (0..steps).map(|i| to * (2.0 * i as f64 / (steps - 1) as f64 - 1.0)).collect()
}

/// The reading, V, of a field along the sensor, with noise.
pub fn read(stream: &mut Stream, field: f64, offset: f64, noise: f64) -> f64 {
    (field - offset + noise * stream.normal()) / K
}

/// A recording of sensor x.
pub fn recording(id: &str, procedure: &str, columns: &[(&str, Vec<f64>)]) -> Value {
    let columns: serde_json::Map<String, Value> =
        columns.iter().map(|(name, values)| (name.to_string(), json!(values))).collect();
    json!({"id": id, "procedure": procedure, "conditions": {"sensor": "x", "coil": "x"}, "columns": columns})
}

/// A sweep of sensor x along coil x; `field_read` gives what it reads for a field in nT.
pub fn sensitivity(seed: u64, fields: &[f64], noise: f64, field_read: impl Fn(f64) -> f64) -> Value {
    let mut stream = Stream::new(seed, "sensitivity");
    let volts = fields.iter().map(|b| read(&mut stream, field_read(*b), 0.0, noise)).collect();
    let time = (0..fields.len()).map(|row| 11.0 * row as f64).collect();
    let current = fields.iter().map(|b| b / COIL).collect();
    recording(
        "sweep",
        "sensor_sensitivity",
        &[("time_s", time), ("coil_x_a", current), ("sensor_x_v", volts)],
    )
}

/// The document with recordings.
pub fn with(recordings: Vec<Value>) -> Value {
    let mut document = bench();
    document["recordings"] = json!(recordings);
    document
}

/// What sensorcal finds.
pub fn run(document: &Value) -> Result<Document, sensorcal::Error> {
    let document = Document::parse(&document.to_string()).expect("a document");
    sensorcal::run(document, &sensorcal::Options::default())
}

/// What it finds of sensor x.
pub fn sensor(document: &Value) -> SensorCalibration {
    let found = run(document).unwrap_or_else(|error| panic!("{error}"));
    found.calibration.expect("a calibration").sensor(Axis::X).expect("sensor x").clone()
}
