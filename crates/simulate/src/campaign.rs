//! A whole campaign: every procedure of a plan, with what is true behind it.

use common::{Axis, Document, Error, FORMAT_VERSION, Facility, Recording};
use nalgebra::Vector3;
use physics::{Basic, EffectInstance, References, Unit, frames};

use crate::bench::{Bench, MOST_ROWS};
use crate::make::{self, World};
use crate::plan::{CalibrationPart, DriveRecord, Plan};
use crate::planned::Planned;
use crate::schedule::{Scheduled, schedule};
use crate::truth::{Electrical, TrueOrientation, Truth, true_calibration};

/// The document that a campaign gives, and what is true behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Campaign {
    /// What the stages read.
    pub document: Document,
    /// What they do not see.
    pub truth: Truth,
}

/// Everything that is decided before the first reading.
pub struct Prepared {
    /// What the document states, without recordings.
    pub document: Document,
    /// The same with what is true instead, exact.
    pub true_document: Document,
    /// The true chain.
    pub basic: Basic,
    /// The effects that act.
    pub effects: Vec<EffectInstance>,
    /// Unit of the readings.
    pub unit: Unit,
    /// The recordings in time.
    pub scheduled: Vec<Scheduled>,
}

/// Carries out a plan.
///
/// The operator sets the currents by what the plan states; the field, the readings and their errors
/// follow from what is true. Errors name the place in the plan.
pub fn campaign(plan: &Plan) -> Result<Campaign, Error> {
    let Prepared { mut document, mut true_document, basic, effects, unit, scheduled } = prepare(plan)?;
    let mut written = Vec::with_capacity(scheduled.len());
    let mut orientations = Vec::with_capacity(scheduled.len());
    for Scheduled { planned, clock_s, local_s, .. } in scheduled {
        let Planned { mut recording, rotation, path, reads, surroundings, amplification, outside, .. } =
            planned;
        orientations
            .push(TrueOrientation { recording: recording.id.clone(), orientation: frames::rows(&rotation) });
        // What theodolites read of an orientation is not what it is: the true chain gets it exactly.
        let conditions = recording.conditions.clone();
        recording.conditions.theodolite = None;
        recording.conditions.orientation = Some(frames::rows(&rotation));
        written.push(make::Written {
            conditions,
            path,
            reads,
            surroundings,
            amplification,
            outside,
            clock_s,
            local_s,
        });
        true_document.recordings.push(recording);
    }
    true_document.check()?;
    let references = References::of(&true_document);
    let set = take_columns(&mut true_document);
    let electrical = match plan.drive {
        DriveRecord::Current => None,
        DriveRecord::Voltage => Some(Electrical::draw(plan)?),
    };
    let world = World {
        plan,
        document: &true_document,
        basic: &basic,
        effects: &effects,
        unit,
        references,
        residual_field_nt: vector(plan.truth.residual_field_nt.as_ref()),
        shield_field_nt: vector(plan.truth.shield_field_nt.as_ref()),
        electrical: electrical.as_ref(),
        wander: make::wander(plan, &set, &written)?,
    };
    document.recordings = world.recordings(set, &written)?;
    let truth = Truth {
        fluxcal: FORMAT_VERSION,
        seed: plan.seed,
        residual_field_nt: world.residual_field_nt.into(),
        offset_wander: world.wander,
        shield_field_nt: plan.truth.shield_field_nt.clone(),
        coil_profile: plan.truth.coil_profile.clone(),
        electrical,
        differential: plan.truth.differential.clone(),
        model: plan.truth.model.clone().unwrap_or_default(),
        calibration: true_document.calibration.unwrap_or_default(),
        orientations,
    };
    Ok(Campaign { document, truth })
}

/// The recordings of a document; it keeps their ids and beginnings.
fn take_columns(document: &mut Document) -> Vec<Recording> {
    let bare = |set: &Recording| Recording {
        id: set.id.clone(),
        procedure: set.procedure.clone(),
        start: set.start.clone(),
        ..Recording::default()
    };
    let bare: Vec<Recording> = document.recordings.iter().map(bare).collect();
    std::mem::replace(&mut document.recordings, bare)
}

/// Checks a plan and puts its recordings in order.
pub fn prepare(plan: &Plan) -> Result<Prepared, Error> {
    let mut document = Document {
        fluxcal: FORMAT_VERSION,
        title: plan.title.clone(),
        facility: plan.facility.clone(),
        instrument: plan.instrument.clone(),
        calibration: plan.calibration.clone(),
        ..Document::default()
    };
    if plan.procedures.is_empty() {
        return Err(Error::document("procedures", "an empty list", "at least one procedure"));
    }
    check_noise(plan)?;
    let unit = unit(&document);
    let stated = Basic::of(&document, unit);
    let true_document = Document {
        calibration: Some(true_calibration(plan)?),
        model: plan.truth.model.clone(),
        facility: plan.facility.clone().map(|facility| Facility { theodolite_arcsec: None, ..facility }),
        ..document.clone()
    };
    let effects = physics::adopt(&true_document).map_err(|error| error.at("truth.model"))?;
    let basic = unit_directions(Basic::of(&true_document, unit))?;
    let bench = Bench { plan, document: &document, stated: &stated, truth: &basic };
    let mut rows = 0.0;
    for (index, procedure) in plan.procedures.iter().enumerate() {
        let path = format!("procedures[{index}]");
        rows += procedure.sequence().rows(&bench, &path)?;
        if rows > MOST_ROWS {
            let found = format!("{rows:.3e} rows so far");
            return Err(Error::document(path, found, format!("at most {MOST_ROWS:.0e} in all")));
        }
    }
    let mut planned = Vec::new();
    for (index, procedure) in plan.procedures.iter().enumerate() {
        planned.extend(procedure.sequence().plan(&bench, &format!("procedures[{index}]"))?);
    }
    let scheduled = schedule(plan, planned)?;
    if let Some(calibration) = &mut document.calibration {
        for part in &plan.unstated {
            match part {
                CalibrationPart::Coils => calibration.coils = None,
                CalibrationPart::Sensors => calibration.sensors = None,
                CalibrationPart::Axes => calibration.axes = None,
                CalibrationPart::Differential => calibration.differential = None,
            }
        }
    }
    Ok(Prepared { document, true_document, basic, effects, unit, scheduled })
}

/// The instrument's noise can be made.
fn check_noise(plan: &Plan) -> Result<(), Error> {
    let Some(instrument) = &plan.instrument else { return Ok(()) };
    for axis in Axis::ALL {
        let exponent = instrument.noise_of(axis).and_then(|noise| noise.flicker_exponent).unwrap_or(1.0);
        if !(0.0..=2.0).contains(&exponent) {
            let path = "instrument.noise.flicker_exponent";
            return Err(Error::document(
                path,
                exponent.to_string(),
                "an exponent from 0 (white) to 2 (random walk)",
            ));
        }
    }
    Ok(())
}

fn unit_directions(mut basic: Basic) -> Result<Basic, Error> {
    for axis in 0..3 {
        for (matrix, key) in [(&mut basic.eta, "coils"), (&mut basic.mu, "sensors")] {
            let length = matrix.column(axis).norm();
            if (length - 1.0).abs() > 1e-3 {
                let path = format!("truth.calibration.axes.{key}.matrix");
                let found = format!("a column of length {length:.6}");
                return Err(Error::document(path, found, "columns that are unit vectors"));
            }
            matrix.column_mut(axis).normalize_mut();
        }
    }
    Ok(basic)
}

/// Volts where a sensitivity in nT/V is stated.
fn unit(stated: &Document) -> Unit {
    let nominal = stated.instrument.as_ref().and_then(|i| i.nominal_sensitivity_nt_per_v).is_some();
    let sensors = stated.calibration.as_ref().and_then(|calibration| calibration.sensors.as_ref());
    let calibrated = sensors.is_some_and(|all| all.iter().any(|(_, s)| s.sensitivity_nt_per_v.is_some()));
    if nominal || calibrated { Unit::Volt } else { Unit::Nanotesla }
}

fn vector(field: Option<&common::PerAxis<f64>>) -> Vector3<f64> {
    Vector3::from(Axis::ALL.map(|axis| field.and_then(|field| field.get(axis)).copied().unwrap_or(0.0)))
}
