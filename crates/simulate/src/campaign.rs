//! A whole campaign: every procedure of a plan, with what is true behind it.

use common::{
    Axis, Calibration, Column, Document, FORMAT_VERSION, Facility, Matrix3x3, Model, Recording, procedure,
};
use nalgebra::Vector3;
use physics::{Basic, Context, References, Unit, frames};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::axes::{self, Planned};
use crate::noise::{Stream, disturb};
use crate::plan::{FreeRun, Plan, Procedure};
use crate::{Error, check};

/// The document that a campaign gives, and what is true behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Campaign {
    /// What the stages read.
    pub document: Document,
    /// What they do not see.
    pub truth: Truth,
}

/// What is true behind a simulated document. It goes to a file of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Truth {
    /// Format version, 1.
    pub fluxcal: u64,
    /// The seed.
    pub seed: u64,
    /// True constants and axes.
    pub calibration: Calibration,
    /// Effects that acted.
    pub model: Model,
    /// Field at the sensors with no drive, GEO, nT.
    pub residual_field_nt: [f64; 3],
    /// True orientation of each recording.
    pub orientations: Vec<TrueOrientation>,
}

/// The true orientation of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct TrueOrientation {
    /// The recording.
    pub recording: String,
    /// R, GEO -> SEN.
    pub orientation: Matrix3x3,
}

/// Carries out a plan.
///
/// The operator sets the currents by what the plan states; the field, the readings and their errors
/// follow from what is true. Errors name the place in the plan.
pub fn campaign(plan: &Plan) -> Result<Campaign, Error> {
    let mut document = Document {
        fluxcal: FORMAT_VERSION,
        title: plan.title.clone(),
        facility: plan.facility.clone(),
        instrument: plan.instrument.clone(),
        calibration: plan.calibration.clone(),
        ..Document::default()
    };
    let unit = unit(&document);
    let stated = Basic::of(&document, unit);
    check::plan(plan, &stated)?;
    let planned = planned(plan, &document, &stated)?;
    document.recordings = planned.iter().map(|planned| planned.recording.clone()).collect();
    document.check()?;

    let truth = true_calibration(plan)?;
    let true_document = Document {
        calibration: Some(truth.clone()),
        model: plan.truth.model.clone(),
        // What theodolites read of an orientation is not what it is: here it is exact.
        facility: plan.facility.clone().map(|facility| Facility { theodolite_arcsec: None, ..facility }),
        ..document.clone()
    };
    let mut basic = Basic::of(&true_document, unit);
    for axis in 0..3 {
        for (matrix, key) in [(&mut basic.eta, "coils"), (&mut basic.mu, "sensors")] {
            let length = matrix.column(axis).norm();
            if (length - 1.0).abs() > 1e-3 {
                let path = format!("truth.calibration.axes.{key}.matrix");
                let found = format!("a column of length {length:.6}");
                return Err(common::Error::document(path, found, "columns that are unit vectors").into());
            }
            matrix.column_mut(axis).normalize_mut();
        }
    }
    let effects = physics::adopt(&true_document)
        .map_err(|source| Error::Physics { path: "truth.model".into(), source })?;
    let residual = plan.truth.residual_field_nt.as_ref();
    let residual_field_nt =
        Axis::ALL.map(|axis| residual.and_then(|field| field.get(axis)).copied().unwrap_or(0.0));
    let references = References::of(&true_document);

    let mut orientations = Vec::new();
    for (Planned { recording, rotation, path, sensors }, written) in
        planned.into_iter().zip(&mut document.recordings)
    {
        let failed = |source| Error::Physics { path: path.clone(), source };
        orientations
            .push(TrueOrientation { recording: recording.id.clone(), orientation: frames::rows(&rotation) });
        let mut set = recording;
        set.conditions.theodolite = None;
        set.conditions.orientation = Some(frames::rows(&rotation));
        let mut context = Context::new(&true_document, &set, references).map_err(failed)?;
        context.unit = unit;
        context.ambient_nt.iter_mut().for_each(|field| *field += Vector3::from(residual_field_nt));
        let readings = physics::predict(&basic, &effects, &context).map_err(failed)?.readings;
        read(plan, &basic, unit, &sensors, &readings, written);
    }
    let truth = Truth {
        fluxcal: FORMAT_VERSION,
        seed: plan.seed,
        calibration: truth,
        model: plan.truth.model.clone().unwrap_or_default(),
        residual_field_nt,
        orientations,
    };
    Ok(Campaign { document, truth })
}

/// Every recording of the plan, without its readings.
fn planned(plan: &Plan, document: &Document, stated: &Basic) -> Result<Vec<Planned>, Error> {
    let instrument = plan.instrument.as_ref().and_then(|instrument| instrument.sensors.clone());
    let all = instrument.unwrap_or_else(|| Axis::ALL.to_vec());
    let theodolite_arcsec = plan.facility.as_ref().and_then(|f| f.theodolite_arcsec).unwrap_or(0.0);
    let mut planned = Vec::new();
    for (index, procedure) in plan.procedures.iter().enumerate() {
        let path = format!("procedures[{index}]");
        match procedure {
            Procedure::AxesOrientation(axes) => {
                let sensors = axes.sensors.clone().unwrap_or_else(|| all.clone());
                let set = |field| currents(stated, field);
                planned.extend(axes::plan(axes, &path, plan.seed, theodolite_arcsec, &sensors, set)?);
            }
            Procedure::FreeRun(run) => planned.push(free_run(run, document, path, all.clone())?),
        }
    }
    Ok(planned)
}

/// The readings with noise and quantisation, as columns.
fn read(
    plan: &Plan,
    basic: &Basic,
    unit: Unit,
    sensors: &[Axis],
    readings: &[Vector3<f64>],
    recording: &mut Recording,
) {
    let instrument = plan.instrument.clone().unwrap_or_default();
    let step = match unit {
        Unit::Volt => instrument.quantisation_v,
        Unit::Nanotesla => instrument.quantisation_nt,
    };
    for &sensor in sensors {
        let mut column: Vec<f64> = readings.iter().map(|reading| reading[sensor.index()]).collect();
        let name = format!("sensor_{sensor}_{}", unit.suffix());
        let mut stream = Stream::new(plan.seed, &format!("{}/{name}", recording.id));
        let sensitivity = basic.sensors[sensor.index()].sensitivity;
        disturb(&instrument, sensor, sensitivity, step.unwrap_or(0.0), &mut stream, &mut column);
        recording.columns.insert(name, Column(column));
    }
}

/// What is stated, with what the truth says otherwise, key by key.
fn true_calibration(plan: &Plan) -> Result<Calibration, common::Error> {
    fn merge(stated: &mut Value, truth: Value) {
        match (stated, truth) {
            (Value::Object(stated), Value::Object(truth)) => {
                for (key, value) in truth {
                    merge(stated.entry(key).or_insert(Value::Null), value);
                }
            }
            (stated, truth) => *stated = truth,
        }
    }
    let wrong = |error: serde_json::Error| {
        common::Error::document("truth.calibration", error.to_string(), "a calibration")
    };
    let mut merged = serde_json::to_value(plan.calibration.clone().unwrap_or_default()).map_err(wrong)?;
    merge(
        &mut merged,
        serde_json::to_value(plan.truth.calibration.clone().unwrap_or_default()).map_err(wrong)?,
    );
    serde_json::from_value(merged).map_err(wrong)
}

/// Volts where a sensitivity in nT/V is stated.
fn unit(stated: &Document) -> Unit {
    let nominal = stated.instrument.as_ref().and_then(|i| i.nominal_sensitivity_nt_per_v).is_some();
    let sensors = stated.calibration.as_ref().and_then(|calibration| calibration.sensors.as_ref());
    let calibrated = sensors.is_some_and(|all| all.iter().any(|(_, s)| s.sensitivity_nt_per_v.is_some()));
    if nominal || calibrated { Unit::Volt } else { Unit::Nanotesla }
}

fn currents(stated: &Basic, field_nt: Vector3<f64>) -> Vector3<f64> {
    Vector3::from_fn(|c, _| {
        let coil = &stated.coils[c];
        if coil.constant_nt_per_a == 0.0 {
            0.0
        } else {
            (field_nt[c] - coil.offset_nt) / coil.constant_nt_per_a
        }
    })
}

fn free_run(run: &FreeRun, document: &Document, path: String, sensors: Vec<Axis>) -> Result<Planned, Error> {
    let recording = Recording {
        id: run.id.clone(),
        procedure: procedure::FREE_RUN.into(),
        conditions: run.conditions.clone(),
        columns: run.columns.clone(),
        ..Recording::default()
    };
    let at = |source| Error::Physics { path: format!("{path}.conditions.orientation"), source };
    let rotation = physics::orientation(document, &recording).map_err(at)?.rotation;
    Ok(Planned { recording, rotation, path, sensors })
}
