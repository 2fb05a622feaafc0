//! Recordings made by hand and plans, for tests; and what is asked of the answers.

use common::{Axis, Departure, Document, Quantity, SensorCalibration};
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
    of(&run(document).unwrap_or_else(|error| panic!("{error}")), Axis::X).clone()
}

/// A sensor of a document that is calibrated.
pub fn of(document: &Document, axis: Axis) -> &SensorCalibration {
    document.calibration.as_ref().and_then(|calibration| calibration.sensor(axis)).expect("a sensor")
}

/// Changes a column of a recording, by row and value.
pub fn change(recording: &mut Value, column: &str, to: impl Fn(usize, f64) -> f64) {
    let column = recording["columns"][column].as_array_mut().expect("a list");
    for (row, value) in column.iter_mut().enumerate() {
        *value = json!(to(row, value.as_f64().expect("a number")));
    }
}

/// Whether a value is within so many standard uncertainties of the truth.
pub fn near(quantity: &Quantity, truth: f64, most: f64) -> bool {
    (quantity.value() - truth).abs() < most * quantity.std().expect("a std")
}

/// The departures that were found.
pub fn found(departures: &[Departure]) -> Vec<&str> {
    departures.iter().filter(|one| one.found).map(|one| one.departure.as_str()).collect()
}

/// A plan for sensors in three coils, with the block and the coils along the axes.
pub fn plan(seed: u64, sensors: &[&str], noise: &Value, effects: Vec<Value>, procedures: Value) -> Value {
    let coil = json!({"resistor_ohm": 1.0, "max_nt": 65000});
    let known = json!({"constant_nt_per_a": 41000.0, "offset_nt": 0.0});
    let constants = json!({"sensitivity_nt_per_v": 6400.0, "offset_nt": 0.3});
    let unit = json!({"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]});
    let temperatures =
        json!({"sensor_temperature_c": 23.0, "electronics_temperature_c": 23.0, "coil_temperature_c": 21.0});
    json!({
        "fluxcal": 1,
        "seed": seed,
        "start": "2026-03-02T08:00:00Z",
        "facility": {"coils": each(&coil)},
        "instrument": {"sensors": sensors, "nominal_sensitivity_nt_per_v": 6400, "noise": noise},
        "calibration": {
            "coils": each(&known),
            "sensors": each(&constants),
            "axes": {"sensors": unit, "coils": unit},
            "reference_conditions": temperatures
        },
        "unstated": ["sensors"],
        "temperatures": temperatures,
        "truth": {
            "model": {"effects": effects},
            "residual_field_nt": {"x": 0.0, "y": 0.0, "z": 0.0},
            "shield_field_nt": {"x": 2.1, "y": -1.4, "z": 3.2}
        },
        "procedures": procedures
    })
}

/// The same for each axis.
pub fn each(one: &Value) -> Value {
    json!({"x": one, "y": one, "z": one})
}

/// The campaign of a plan.
pub fn simulated(plan: &Value) -> simulate::Campaign {
    let plan = simulate::Plan::parse(&plan.to_string()).expect("a plan");
    simulate::campaign(&plan).expect("simulated")
}

/// The report's own campaign.
pub fn magsat() -> Value {
    serde_json::from_str(&testkit::read_fixture("plans/magsat.json")).expect("JSON")
}

/// The document with what sensorcal finds.
pub fn calibrated(document: Document) -> Document {
    sensorcal::run(document, &sensorcal::Options::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// What is to be said of intervals that do not hold the truth as often as a band says, of so many judged.
pub fn outside(name: &str, held: &[bool], band: [f64; 2], judged: usize) -> Option<String> {
    let inside = held.iter().filter(|held| **held).count();
    let share = inside as f64 / held.len() as f64;
    println!("{name}: {:.1} % of {}", 100.0 * share, held.len());
    let agrees = testkit::agrees(inside, held.len(), band, judged);
    (!agrees).then(|| format!("{name}: {share:.3} of {}", held.len()))
}

/// A parameter of an effect that is true; zero where there is no such effect.
pub fn true_effect(truth: &simulate::Truth, name: &str, sensor: Axis, parameter: &str) -> f64 {
    let effect = truth.model.effects.iter().find(|e| e.effect == name && e.sensor == Some(sensor));
    effect.map_or(0.0, |effect| effect.parameters[parameter].value())
}

/// Coefficients of a sensor by name, each with what is true of it: of temperatures, and of fields across.
pub fn coefficients<'a>(
    sensor: &'a SensorCalibration,
    truth: &simulate::Truth,
    axis: Axis,
) -> [Vec<(String, &'a Quantity, f64)>; 2] {
    let one = |effect: &str, parameter: &str, quantity: &'a Quantity| {
        (format!("{effect} {parameter}"), quantity, true_effect(truth, effect, axis, parameter))
    };
    let (mut thermal, mut across) = (Vec::new(), Vec::new());
    let temperature = sensor.temperature.as_ref().expect("temperatures");
    for (part, of) in [("", &temperature.sensor), ("electronics_", &temperature.electronics)] {
        let of = of.as_ref().expect("a part");
        let [scale, shift] = ["sensitivity", "offset"].map(|what| format!("{what}_{part}temperature"));
        let [scale2, shift2] =
            [&of.sensitivity_ppm_per_k2, &of.offset_nt_per_k2].map(|of| of.as_ref().expect("a curvature"));
        thermal.push(one(&scale, "coefficient_ppm_per_k", &of.sensitivity_ppm_per_k));
        thermal.push(one(&scale, "curvature_ppm_per_k2", scale2));
        thermal.push(one(&shift, "coefficient_nt_per_k", &of.offset_nt_per_k));
        thermal.push(one(&shift, "curvature_nt_per_k2", shift2));
    }
    let cross = sensor.cross_field.as_ref().expect("transverse fields");
    for (effect, found) in [("cross_field", &cross.offset), ("cross_field_sensitivity", &cross.sensitivity)] {
        across.extend(found.iter().map(|(name, quantity)| one(effect, name, quantity)));
    }
    [thermal, across]
}
