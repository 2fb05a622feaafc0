//! A whole campaign: every procedure of a plan, with what is true behind it.

use common::{
    Axis, Calibration, Column, Conditions, Document, FORMAT_VERSION, Matrix3x3, Model, Recording, procedure,
};
use nalgebra::Vector3;
use physics::{Basic, Context, References, Unit, frames};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::axes::{self, Planned};
use crate::noise::{Stream, disturb};
use crate::plan::{AcDrive, AxesProcedure, Plan, Procedure};

/// Samples that one recording may have.
const MOST_ROWS: f64 = 1e8;

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
    let stated_document = Document {
        fluxcal: FORMAT_VERSION,
        facility: plan.facility.clone(),
        instrument: plan.instrument.clone(),
        calibration: plan.calibration.clone(),
        ..Document::default()
    };
    let true_document = Document {
        calibration: Some(true_calibration(plan)),
        model: plan.truth.model.clone(),
        facility: plan
            .facility
            .clone()
            .map(|facility| common::Facility { theodolite_arcsec: None, ..facility }),
        ..stated_document.clone()
    };
    let unit = unit(&stated_document);
    let stated = Basic::of(&stated_document, unit);
    let mut basic = Basic::of(&true_document, unit);
    for axis in 0..3 {
        basic.eta.column_mut(axis).normalize_mut();
        basic.mu.column_mut(axis).normalize_mut();
    }
    let effects = physics::adopt(&true_document).map_err(physical("truth.model.effects"))?;
    let residual = plan.truth.residual_field_nt.as_ref();
    let residual_field_nt =
        Axis::ALL.map(|axis| residual.and_then(|field| field.get(axis)).copied().unwrap_or(0.0));

    let mut document = Document { title: plan.title.clone(), ..stated_document };
    let mut orientations = Vec::new();
    for (index, procedure) in plan.procedures.iter().enumerate() {
        let path = format!("procedures[{index}]");
        let (planned, sensors) = match procedure {
            Procedure::AxesOrientation(axes) => {
                check_axes(axes, plan, &stated, &path)?;
                let sigma = plan.facility.as_ref().and_then(|f| f.theodolite_arcsec).unwrap_or(0.0);
                (
                    axes::plan(axes, &path, plan.seed, sigma, |field| currents(&stated, field))?,
                    axes.sensors.clone(),
                )
            }
            Procedure::FreeRun(run) => (vec![free_run(run, &document, path)?], Axis::ALL.to_vec()),
        };
        for Planned { mut recording, rotation, path } in planned {
            let readings = {
                let mut set = recording.clone();
                set.conditions.theodolite = None;
                set.conditions.orientation = Some(frames::rows(&rotation));
                let references = References::of(&true_document);
                let mut context = Context::new(&true_document, &set, references).map_err(physical(&path))?;
                context.unit = unit;
                context.ambient_nt.iter_mut().for_each(|field| *field += Vector3::from(residual_field_nt));
                physics::predict(&basic, &effects, &context).map_err(physical(&path))?.readings
            };
            orientations.push(TrueOrientation {
                recording: recording.id.clone(),
                orientation: frames::rows(&rotation),
            });
            read(plan, &basic, unit, &sensors, &readings, &mut recording);
            document.recordings.push(recording);
        }
    }
    let truth = Truth {
        fluxcal: FORMAT_VERSION,
        seed: plan.seed,
        calibration: true_document.calibration.unwrap_or_default(),
        model: plan.truth.model.clone().unwrap_or_default(),
        residual_field_nt,
        orientations,
    };
    Ok(Campaign { document, truth })
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

/// What is stated, with what the truth says otherwise.
fn true_calibration(plan: &Plan) -> Calibration {
    let stated = plan.calibration.clone().unwrap_or_default();
    match plan.truth.calibration.clone() {
        None => stated,
        Some(truth) => Calibration {
            coils: truth.coils.or(stated.coils),
            sensors: truth.sensors.or(stated.sensors),
            axes: truth.axes.or(stated.axes),
            reference_conditions: truth.reference_conditions.or(stated.reference_conditions),
            extra: truth.extra,
        },
    }
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

fn free_run(run: &crate::plan::FreeRun, document: &Document, path: String) -> Result<Planned, Error> {
    let recording = Recording {
        id: run.id.clone(),
        procedure: procedure::FREE_RUN.into(),
        conditions: run.conditions.clone(),
        columns: run.columns.clone(),
        ..Recording::default()
    };
    let at = |source| Error::Physics { path: format!("{path}.conditions.orientation"), source };
    let rotation = physics::orientation(document, &recording).map_err(at)?.rotation;
    Ok(Planned { recording, rotation, path })
}

/// Refuses what no facility can do, with the place in the plan.
fn check_axes(axes: &AxesProcedure, plan: &Plan, stated: &Basic, path: &str) -> Result<(), common::Error> {
    let positive = |key: &str, value: f64| {
        if value.is_finite() && value > 0.0 {
            Ok(())
        } else {
            Err(common::Error::document(format!("{path}.{key}"), value.to_string(), "a positive number"))
        }
    };
    positive("drive_nt", axes.drive_nt)?;
    positive("repeats", axes.repeats as f64)?;
    if let Some(AcDrive { hz, cycles, rate_hz, .. }) = axes.ac {
        positive("ac.hz", hz)?;
        positive("ac.cycles", cycles)?;
        positive("ac.rate_hz", rate_hz)?;
        if cycles / hz * rate_hz > MOST_ROWS {
            return Err(common::Error::document(
                format!("{path}.ac"),
                format!("{:.3e} samples in one recording", cycles / hz * rate_hz),
                format!("at most {MOST_ROWS:.0e}"),
            ));
        }
    }
    let noise = plan.instrument.iter().flat_map(|instrument| Axis::ALL.map(|axis| instrument.noise_of(axis)));
    if noise.flatten().any(|noise| noise.flicker_nt2_per_hz_at_1hz.unwrap_or(0.0) > 0.0) {
        return Err(common::Error::document(
            "instrument.noise.flicker_nt2_per_hz_at_1hz",
            "flicker noise",
            "white noise only, which is what this version simulates; leave the flicker part out of the plan",
        ));
    }
    for axis in Axis::ALL {
        let coil = plan.facility.as_ref().and_then(|f| f.coils.as_ref()).and_then(|coils| coils.get(axis));
        let largest =
            axes.drives.iter().map(|drive| drive_on(drive, axis, axes.drive_nt)).fold(0.0, f64::max);
        if largest > 0.0 && stated.coils[axis.index()].constant_nt_per_a == 0.0 {
            return Err(common::Error::document(
                format!("{path}.drives"),
                format!("a drive of coil {axis}, whose constant is not stated"),
                format!("calibration.coils.{axis}.constant_nt_per_a in the plan"),
            ));
        }
        if let Some(max) = coil.and_then(|coil| coil.max_nt).filter(|max| largest > *max) {
            return Err(common::Error::document(
                format!("{path}.drive_nt"),
                format!("{largest} nT on coil {axis}"),
                format!("at most {max} nT, which is what facility.coils.{axis}.max_nt allows"),
            ));
        }
    }
    Ok(())
}

fn drive_on(drive: &crate::plan::Drive, axis: Axis, drive_nt: f64) -> f64 {
    match drive {
        crate::plan::Drive::Vector(vector) => vector[axis.index()].abs(),
        crate::plan::Drive::Named(name) if name.ends_with(axis.letter()) => drive_nt,
        crate::plan::Drive::Named(_) => 0.0,
    }
}

fn physical(path: &str) -> impl Fn(physics::Error) -> Error + '_ {
    move |source| Error::Physics { path: path.into(), source }
}
