//! The plan that a design begins with, from a file or an ordinary one; and the plan that proves the design.

use common::{Axis, Document, Noise, NoiseOfSensors, Quantity};
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::given::{Given, Times, listed};
use super::least::Recordings;
use nalgebra::Matrix3;

/// A sensor is driven to no more than this share of the instrument's range.
const WITHIN_RANGE: f64 = 0.95;
/// Relative standard uncertainty of constants of coils and sensors that the plan leaves to be found.
const TO_BE_FOUND: f64 = 5e-6;
/// Temperatures of a run of the report: 13 levels, of sensor and electronics.
const LEVELS: usize = 13;

/// A facility with three coils of 50 000 nT and a quiet instrument.
pub fn ordinary() -> Value {
    let each = |of: &dyn Fn(Axis) -> Value| -> Value {
        Axis::ALL.into_iter().map(|axis| (axis.to_string(), of(axis))).collect::<Map<String, Value>>().into()
    };
    json!({
        "fluxcal": 1,
        "title": "Directions of sensors and coils, as axescal design has them recorded (simulated)",
        "seed": 1,
        "facility": {"coils": each(&|_| json!({"max_nt": 50000.0})), "theodolite_arcsec": 1.0, "theodolite_shared_arcsec": 0.3, "residual_field_std_nt": 0.2},
        "instrument": {
            "range_nt": 64000.0, "sensors": ["x", "y", "z"], "nominal_sensitivity_nt_per_v": 6400.0,
            "noise": {"white_rms_nt": 0.1}
        },
        "calibration": {
            "coils": each(&|_| json!({"constant_nt_per_a": {"value": 40000.0, "std": 0.2}, "offset_nt": {"value": 0.0, "std": 0.1}})),
            "sensors": each(&|_| json!({"sensitivity_nt_per_v": {"value": 6400.0, "std": 0.032}, "offset_nt": {"value": 0.0, "std": 0.3}}))
        },
        "procedures": []
    })
}

/// What of a plan says how long things take and what else is done; its other keys are those of a document.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Planned {
    timing: Times,
    procedures: Vec<Procedure>,
}

#[derive(Deserialize)]
struct Procedure {
    procedure: String,
    deviations_k: Option<Vec<f64>>,
    parts: Option<Vec<String>>,
    sensors: Option<Vec<Axis>>,
}

/// Reads what a design needs from a plan.
pub fn given(plan: &Value) -> Result<Given, common::Error> {
    let of_document = ["fluxcal", "facility", "instrument", "calibration"];
    let document: Map<String, Value> =
        of_document.iter().filter_map(|key| Some((key.to_string(), plan.get(*key)?.clone()))).collect();
    let document = Document::parse(&Value::from(document).to_string())?;
    let planned: Planned = common::at_path(&plan.to_string())?;
    let facility = document.facility.clone().unwrap_or_default();
    let instrument = document.instrument.clone().unwrap_or_default();
    let calibration = document.calibration.clone().unwrap_or_default();
    let range = instrument.range_nt.map_or(f64::INFINITY, |range| WITHIN_RANGE * range);
    let coil = |axis: Axis| facility.coils.as_ref().and_then(|coils| coils.get(axis));
    let constant = |axis: Axis| calibration.coil(axis).and_then(|coil| coil.constant_nt_per_a.as_ref());
    let sensitivity = |axis: Axis| {
        let sensor = calibration.sensor(axis)?;
        sensor.sensitivity_nt_per_v.as_ref().or(sensor.sensitivity_nt_per_nt.as_ref())
    };
    let mut coil_nt = [0.0; 3];
    for axis in Axis::ALL {
        let largest = coil(axis).and_then(|coil| coil.max_nt).filter(|max| *max > 0.0 && max.is_finite());
        let Some(largest) = largest else {
            let path = format!("facility.coils.{axis}.max_nt");
            let expected = "the largest field of the coil, or --drive-nt";
            return Err(common::Error::document(path, "no positive number", expected));
        };
        coil_nt[axis.index()] = largest.min(range);
    }
    let noise = instrument.noise.as_ref().ok_or_else(|| {
        common::Error::document("instrument.noise", "nothing", "the noise of a reading, or --noise-nt")
    })?;
    let relative =
        |quantity: Option<&Quantity>| quantity.and_then(Quantity::relative_std).unwrap_or(TO_BE_FOUND);
    let offset = |axis: Axis| calibration.sensor(axis)?.offset_nt.as_ref()?.std().filter(|std| *std > 0.0);
    let offsets: Option<Vec<f64>> = Axis::ALL.into_iter().map(offset).collect();
    let gradient = |axis: Axis| {
        let std = coil(axis)?.gradient_nt_per_m_a.as_ref()?.std()?;
        Some(std / constant(axis)?.value().abs())
    };
    let position = |axis: Axis| instrument.positions_m.as_ref()?.get(axis).copied();
    let width = instrument
        .quantisation_v
        .zip(sensitivity(Axis::X).map(Quantity::value).or(instrument.nominal_sensitivity_nt_per_v))
        .map(|(step, sensitivity)| step * sensitivity.abs());
    let temperature_levels = planned.procedures.iter().map(Procedure::levels).sum();
    Ok(Given {
        coil_nt,
        noise: Axis::ALL.map(|axis| noise.of(axis).cloned().unwrap_or_default()),
        field_noise: facility.noise.clone().unwrap_or_default(),
        quantisation_nt: width.or(instrument.quantisation_nt).unwrap_or(0.0),
        theodolite_arcsec: facility.theodolite_arcsec.unwrap_or(0.0),
        theodolite_shared_arcsec: facility.theodolite_shared_arcsec.unwrap_or(0.0),
        coil_relative: Axis::ALL.map(|axis| relative(constant(axis))),
        sensor_relative: Axis::ALL.map(|axis| relative(sensitivity(axis))),
        residual_field_nt: facility.residual_field_std_nt.filter(|std| *std > 0.0),
        offset_nt: offsets.map(|all| all.into_iter().fold(0.0, f64::max)),
        gradient_per_m: Axis::ALL.map(|axis| gradient(axis).unwrap_or(0.0)),
        positions_m: Axis::ALL.map(|axis| position(axis).unwrap_or([0.0; 3])),
        times: Times { temperature_levels, ..planned.timing },
    })
}

impl Procedure {
    /// Levels of temperature that it waits for.
    fn levels(&self) -> usize {
        if self.procedure != common::procedure::TEMPERATURE_RUN {
            return 0;
        }
        self.deviations_k.as_ref().map_or(LEVELS, Vec::len)
            * self.parts.as_ref().map_or(2, Vec::len)
            * self.sensors.as_ref().map_or(3, Vec::len)
    }
}

/// The part of a plan that makes these recordings.
pub fn procedure(given: &Given, candidates: &[Matrix3<f64>], recordings: &Recordings) -> Value {
    let drives: Vec<[f64; 3]> =
        given.drives(&recordings.setting).iter().map(|drive| (*drive).into()).collect();
    json!({
        "procedure": common::procedure::AXES_ORIENTATION,
        "id": "axes",
        "orientations": listed(candidates, &recordings.orientations),
        "drive_nt": given.coil_nt.into_iter().fold(0.0, f64::max),
        "drives": drives,
        "repeats": recordings.setting.readings,
        "theodolite_angles": true,
        "theodolite_readings": recordings.setting.theodolite_readings,
        "fixture_std_arcmin": 0.5,
    })
}

/// The plan with these recordings in the place of those for the directions that it had.
pub fn proof(plan: &Value, procedure: &Value) -> Value {
    let mut plan = plan.clone();
    if let Some(Value::Array(procedures)) = plan.get_mut("procedures") {
        let axes = |one: &Value| one["procedure"] == common::procedure::AXES_ORIENTATION;
        let at = procedures.iter().position(axes).unwrap_or(procedures.len());
        procedures.retain(|one| !axes(one));
        procedures.insert(at, procedure.clone());
    }
    plan
}

/// The noise of the plan, the same for all sensors, to be changed.
pub fn noise(plan: &Value) -> Noise {
    let noise = plan["instrument"].get("noise").and_then(|noise| NoiseOfSensors::deserialize(noise).ok());
    noise.and_then(|noise| noise.of(Axis::X).cloned()).unwrap_or_default()
}
