//! A whole campaign: every procedure of a plan, with what is true behind it.

use common::number::bare;
use common::{Axis, Document, Error, FORMAT_VERSION, Facility, Recording};
use physics::{Basic, EffectInstance, References, Unit, frames};
use std::collections::HashSet;

use crate::bench::{Bench, MOST_ROWS, exponent, positive};
use crate::make::{self, World};
use crate::plan::{CalibrationPart, DriveRecord, Plan, TruthPlan};
use crate::schedule::{Scheduled, schedule};
use crate::timing::Timing;
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
    document: Document,
    /// The same with what is true instead, exact.
    true_document: Document,
    basic: Basic,
    effects: Vec<EffectInstance>,
    unit: Unit,
    pub scheduled: Vec<Scheduled>,
}

/// Carries out a plan.
///
/// The operator sets the currents by what the plan states; the field, the readings and their errors
/// follow from what is true. Errors name the place in the plan.
pub fn campaign(plan: &Plan) -> Result<Campaign, Error> {
    let Prepared { mut document, mut true_document, basic, effects, unit, mut scheduled } = prepare(plan)?;
    let mut orientations = Vec::with_capacity(scheduled.len());
    for Scheduled { planned, .. } in &mut scheduled {
        let orientation = frames::rows(&planned.rotation);
        let conditions = planned.recording.conditions.clone();
        let left = Recording { conditions, ..Recording::default() };
        let mut recording = std::mem::replace(&mut planned.recording, left);
        // What theodolites read of an orientation is not what it is: the true chain gets it exactly.
        recording.conditions.theodolite = None;
        recording.conditions.orientation = Some(orientation);
        orientations.push(TrueOrientation { recording: recording.id.clone(), orientation });
        true_document.recordings.push(recording);
    }
    true_document.check()?;
    if let Some(outside) = &plan.truth.outside {
        let main = References { outside_nt: outside.main_field_nt.map(Some), ..References::default() };
        physics::state_references(&mut true_document, &main);
    }
    let references = References::of(&true_document);
    let set = take_columns(&mut true_document);
    let electrical = match plan.drive {
        DriveRecord::Current => None,
        DriveRecord::Voltage => Some(Electrical::draw(plan)?),
    };
    let offset_wander = make::wander(plan, &set, &scheduled)?;
    let wander = offset_wander.iter().map(|wander| (wander.recording.clone(), wander.offset_nt)).collect();
    let world = World { plan, document: true_document, basic, effects, unit, references, electrical, wander };
    document.recordings = world.recordings(set, &scheduled)?;
    let told = plan.truth.clone();
    let truth = Truth {
        fluxcal: FORMAT_VERSION,
        seed: plan.seed,
        residual_field_nt: make::vector(told.residual_field_nt.as_ref()).into(),
        offset_wander,
        shield_field_nt: told.shield_field_nt,
        coil_profile: told.coil_profile,
        electrical: world.electrical,
        differential: told.differential,
        model: told.model.unwrap_or_default(),
        calibration: world.document.calibration.unwrap_or_default(),
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
    document.check()?;
    check_noise(plan)?;
    check_timing(&plan.timing)?;
    let unit = unit(&document, &plan.truth);
    let stated = Basic::of(&document, unit);
    let mut true_document = Document {
        calibration: Some(true_calibration(plan)?),
        model: plan.truth.model.clone(),
        facility: plan.facility.clone().map(|facility| Facility {
            theodolite_arcsec: None,
            theodolite_shared_arcsec: None,
            ..facility
        }),
        ..document.clone()
    };
    let effects = physics::adopt(&true_document).map_err(|error| error.at("truth.model"))?;
    let basic = unit_directions(Basic::of(&true_document, unit), &mut true_document)?;
    let bench = Bench {
        seed: plan.seed,
        start: plan.start.as_deref(),
        timing: &plan.timing,
        outside: plan.truth.outside.as_ref(),
        differential: plan.truth.differential.as_ref(),
        document: &document,
        stated: &stated,
        truth: &basic,
    };
    let mut rows = 0.0;
    for (index, procedure) in plan.procedures.iter().enumerate() {
        let path = format!("procedures[{index}]");
        rows += procedure.sequence().rows(&bench, &path)?;
        if rows > MOST_ROWS {
            let found = format!("{} rows so far", bare(rows));
            return Err(Error::document(path, found, format!("at most {} in all", bare(MOST_ROWS))));
        }
    }
    let mut planned = Vec::new();
    for (index, procedure) in plan.procedures.iter().enumerate() {
        planned.extend(procedure.sequence().plan(&bench, &format!("procedures[{index}]"))?);
    }
    let scheduled = schedule(plan, planned)?;
    check_ids(&scheduled)?;
    check_columns(&effects, &scheduled)?;
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

fn check_noise(plan: &Plan) -> Result<(), Error> {
    let TruthPlan { outside, site, offset_wander, differential, .. } = &plan.truth;
    let (outside, pair) = (outside.as_ref(), differential.as_ref());
    let storm = outside.and_then(|outside| outside.storm.as_ref());
    let instrument = |axis| plan.instrument.as_ref().and_then(|instrument| instrument.noise_of(axis));
    let of_instrument = Axis::ALL.map(|axis| ("instrument.noise".to_string(), instrument(axis)));
    let of_outside = [
        ("outside.background", outside.and_then(|outside| outside.background.as_ref())),
        ("outside.station", outside.and_then(|outside| outside.station.as_ref())),
        ("outside.storm.unrest", storm.and_then(|storm| storm.unrest.as_ref())),
    ];
    let of_site = site.iter().flat_map(|site| site.all());
    let of_site = of_site.map(|(site, of)| (format!("truth.site.{}.noise", site.name()), Some(&of.noise)));
    let others = [
        ("offset_wander", offset_wander.as_ref()),
        ("differential.reference_noise", pair.and_then(|pair| pair.reference_noise.as_ref())),
        ("differential.third.noise", pair.and_then(|pair| pair.third.as_ref()?.noise.as_ref())),
    ];
    let named = |(path, noise): (&str, _)| (format!("truth.{path}"), noise);
    let all = of_instrument.into_iter().chain(of_outside.map(named)).chain(of_site).chain(others.map(named));
    for (path, noise) in all {
        noise.map_or(Ok(()), |noise| exponent(&path, noise))?;
    }
    if let Some(storm) = storm {
        positive("truth.outside.storm", [("growth_s", storm.growth_s), ("recovery_s", storm.recovery_s)])?;
    }
    Ok(())
}

fn check_timing(timing: &Timing) -> Result<(), Error> {
    for (key, value) in [
        ("field_settle_s", timing.field_settle_s),
        ("orientation_s", timing.orientation_s),
        ("theodolite_s", timing.theodolite_s),
        ("temperature_settle_s", timing.temperature_settle_s),
        ("reversal_s", timing.reversal_s),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            let expected = "a time that is not negative";
            return Err(Error::document(format!("timing.{key}"), value.to_string(), expected));
        }
    }
    positive("timing", [("reading_s", timing.reading_s)])
}

/// An effect that follows a column has it in some recording.
fn check_columns(effects: &[EffectInstance], scheduled: &[Scheduled]) -> Result<(), Error> {
    for (index, effect) in effects.iter().enumerate() {
        let Some(column) = &effect.column else { continue };
        if !scheduled.iter().any(|scheduled| make::holds(&scheduled.planned.recording, column)) {
            let path = format!("truth.model.effects[{index}].column");
            let expected = "a column that one of the recordings has";
            return Err(Error::document(path, format!("\"{column}\""), expected));
        }
    }
    Ok(())
}

fn check_ids(scheduled: &[Scheduled]) -> Result<(), Error> {
    let mut seen = HashSet::new();
    for Scheduled { planned, .. } in scheduled {
        if !seen.insert(planned.recording.id.as_str()) {
            let found = format!("a second recording \"{}\"", planned.recording.id);
            let expected = "ids of recordings that are unique; change the procedure's `id`, or name each sensor and coil once";
            return Err(Error::document(planned.path.clone(), found, expected));
        }
    }
    Ok(())
}

/// Makes the columns of μ and η unit vectors, in the chain and in what is told of the truth.
fn unit_directions(mut basic: Basic, document: &mut Document) -> Result<Basic, Error> {
    let axes = document.calibration.as_mut().and_then(|calibration| calibration.axes.as_mut());
    let (mut sensors, mut coils) = match axes {
        Some(axes) => (axes.sensors.as_mut(), axes.coils.as_mut()),
        None => (None, None),
    };
    for (matrix, told, key) in
        [(&mut basic.eta, &mut coils, "coils"), (&mut basic.mu, &mut sensors, "sensors")]
    {
        for axis in 0..3 {
            let length = matrix.column(axis).norm();
            if (length - 1.0).abs() > 1e-3 {
                let path = format!("truth.calibration.axes.{key}.matrix");
                let found = format!("a column of length {}", bare(length));
                let expected = "columns that are unit vectors, here or, where the truth says nothing, in `calibration.axes`";
                return Err(Error::document(path, found, expected));
            }
            matrix.column_mut(axis).normalize_mut();
        }
        if let Some(told) = told.as_mut().and_then(|told| told.matrix.as_mut()) {
            *told = frames::rows(matrix);
        }
    }
    Ok(basic)
}

/// Volts where a sensitivity in nT/V is stated or true.
fn unit(stated: &Document, truth: &TruthPlan) -> Unit {
    let nominal = stated.instrument.as_ref().and_then(|i| i.nominal_sensitivity_nt_per_v).is_some();
    let calibrated = [&stated.calibration, &truth.calibration].into_iter().flatten().any(|calibration| {
        let sensors = calibration.sensors.iter().flat_map(|all| all.iter());
        sensors.into_iter().any(|(_, sensor)| sensor.sensitivity_nt_per_v.is_some())
    });
    if nominal || calibrated { Unit::Volt } else { Unit::Nanotesla }
}
