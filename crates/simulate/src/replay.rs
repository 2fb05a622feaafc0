//! A document with calibration and model, its readings replaced by what they predict.

use common::{Axis, Column, Document, Error, Noise, Recording, procedure};
use nalgebra::Vector3;
use physics::{Basic, Context, EffectInstance, LeftOut, References, Setting};
use rayon::prelude::*;

/// A replayed document and what is to be said of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Replayed {
    /// The document.
    pub document: Document,
    /// What was assumed, in words.
    pub notes: Vec<String>,
}

/// Replaces the readings of every recording by what `calibration` and `model` predict for its drive,
/// orientation, temperatures and times. Missing readings stay missing.
///
/// With a seed the declared noise and the codes are added. What the document does not state is nominal, and
/// said; a drive of a coil without a constant, or a reading in V without a sensitivity, is refused.
pub fn replay(document: &Document, noise_seed: Option<u64>) -> Result<Replayed, Error> {
    let effects = physics::adopt(document).map_err(|error| error.at("model"))?;
    let references = References::stated(document);
    let one = |index: usize| recording(document, index, &effects, references, noise_seed);
    let replayed: Vec<Result<_, Error>> = (0..document.recordings.len()).into_par_iter().map(one).collect();
    let replayed = replayed.into_iter().collect::<Result<Vec<_>, _>>()?;
    let (recordings, left_out): (_, Vec<Vec<LeftOut>>) = replayed.into_iter().unzip();
    let left_out: Vec<LeftOut> = left_out.into_iter().flatten().collect();
    let notes = notes(document).into_iter().chain(words(&left_out)).collect();
    Ok(Replayed { document: Document { recordings, ..document.clone() }, notes })
}

fn recording(
    document: &Document,
    index: usize,
    effects: &[EffectInstance],
    references: References,
    noise_seed: Option<u64>,
) -> Result<(Recording, Vec<LeftOut>), Error> {
    let recorded = &document.recordings[index];
    let path = format!("recordings[{index}]");
    if recorded.table.is_some() {
        let expected = "the readings under `columns`, which is what replay can replace";
        return Err(Error::document(format!("{path}.table"), "a file beside the document", expected));
    }
    recorded.at_hand(&path)?;
    let at = |error: physics::Error| error.at(&path);
    let Setting { basic, context } = Setting::of(document, recorded, references).map_err(at)?;
    let differential = context.reference_nt.is_some();
    let prefix = if differential { "test" } else { "sensor" };
    if !differential {
        check_coils(&basic, &context, &path)?;
    }
    let suffix = if differential { "nt" } else { context.unit.suffix() };
    let (prediction, left_out) = physics::predict_acting(&basic, effects, &context).map_err(at)?;
    let mut replayed = recorded.clone();
    for axis in Axis::ALL {
        let name = format!("{prefix}_{axis}_{suffix}");
        let Some(column) = replayed.columns.get_mut(&name) else { continue };
        let sensitivity = basic.sensors[axis.index()].sensitivity;
        if suffix == "v" && !states_sensitivity(document, axis) {
            let expected = format!(
                "calibration.sensors.{axis}.sensitivity_nt_per_v, or instrument.nominal_sensitivity_nt_per_v"
            );
            let found = "readings in V without a sensitivity";
            return Err(Error::document(format!("{path}.columns.{name}"), found, expected));
        }
        let values = prediction.readings.iter().map(|reading| reading[axis.index()]);
        let declared = document.instrument.as_ref().and_then(|instrument| instrument.noise_of(axis));
        let errors = errors(noise_seed, recorded, &name, declared, &path)?;
        fill(column, values.zip(errors).map(|(value, error)| value + error / sensitivity));
        if noise_seed.is_some() {
            let instrument = document.instrument.clone().unwrap_or_default();
            let width = if suffix == "v" { instrument.quantisation_v } else { instrument.quantisation_nt };
            noise::quantise(column, width.unwrap_or(0.0));
        }
    }
    let scalar = [procedure::COIL_CONSTANT, procedure::COIL_GRADIENT].contains(&recorded.procedure.as_str());
    if let Some(column) = replayed.columns.get_mut("reference_nt").filter(|_| scalar) {
        let std = document.facility.as_ref().and_then(|facility| facility.reference_std_nt);
        let declared = Noise { white_rms_nt: std, ..Noise::default() };
        let errors = errors(noise_seed, recorded, "reference_nt", Some(&declared), &path)?;
        let lengths = prediction.field_geo.iter().map(Vector3::norm);
        fill(column, lengths.zip(errors).map(|(value, error)| value + error));
    }
    Ok((replayed, left_out))
}

/// A line for each effect and what it lacks.
fn words(left_out: &[LeftOut]) -> Vec<String> {
    let mut seen: Vec<&LeftOut> = Vec::new();
    for one in left_out {
        if !seen.iter().any(|other| other.who == one.who && other.what == one.what) {
            seen.push(one);
        }
    }
    seen.iter()
        .map(|LeftOut { recording, who, what }| {
            let others = left_out.iter().filter(|one| one.who == *who && one.what == *what).count() - 1;
            let others = if others > 0 { format!(" and {others} more") } else { String::new() };
            format!("{who} is not applied in recording \"{recording}\"{others}: {what} is missing")
        })
        .collect()
}

fn fill(column: &mut Column, values: impl Iterator<Item = f64>) {
    column.iter_mut().zip(values).filter(|(old, _)| old.is_finite()).for_each(|(old, new)| *old = new);
}

/// The declared noise of a column, nT; zero without a seed.
fn errors(
    seed: Option<u64>,
    recorded: &Recording,
    name: &str,
    declared: Option<&Noise>,
    path: &str,
) -> Result<Vec<f64>, Error> {
    let rows = recorded.rows();
    let (Some(seed), Some(declared)) = (seed, declared) else { return Ok(vec![0.0; rows]) };
    let time = recorded.column("time_s").filter(|time| time.iter().all(|t| t.is_finite()));
    noise::series(declared, seed, &format!("{}/{name}", recorded.id), rows, time).map_err(|error| {
        Error::document(path, error.to_string(), "exponents from 0 to 2, and times without such gaps")
    })
}

fn states_sensitivity(document: &Document, axis: Axis) -> bool {
    let sensor = document.calibration.as_ref().and_then(|calibration| calibration.sensor(axis));
    sensor.is_some_and(|sensor| sensor.sensitivity_nt_per_v.is_some())
        || document.instrument.as_ref().is_some_and(|i| i.nominal_sensitivity_nt_per_v.is_some())
}

fn check_coils(basic: &Basic, context: &Context<'_>, path: &str) -> Result<(), Error> {
    for coil in Axis::ALL {
        let driven = context.current_a.iter().any(|current| current[coil.index()].abs() > 0.0);
        if driven && basic.coils[coil.index()].constant_nt_per_a == 0.0 {
            let found = format!("a drive of coil {coil}, whose constant is not known");
            let expected =
                format!("calibration.coils.{coil}.constant_nt_per_a; run coilcal first, or state it");
            return Err(Error::document(path, found, expected));
        }
    }
    Ok(())
}

fn notes(document: &Document) -> Vec<String> {
    let mut notes = Vec::new();
    let calibration = document.calibration.as_ref();
    let axes = calibration.and_then(|calibration| calibration.axes.as_ref());
    let differential = |recording: &Recording| recording.procedure == procedure::DIFFERENTIAL;
    if document.recordings.iter().any(|recording| !differential(recording)) {
        if axes.is_none_or(|axes| axes.sensors.is_none()) {
            notes.push("directions of the sensors are not stated: assumed along SEN".into());
        }
        if axes.is_none_or(|axes| axes.coils.is_none()) {
            notes.push("directions of the coils are not stated: assumed along GEO".into());
        }
    }
    if document.recordings.iter().any(differential) && calibration.is_none_or(|c| c.differential.is_none()) {
        let nothing = "calibration.differential is not stated: the test instrument is assumed to read like the reference";
        notes.push(nothing.into());
    }
    notes
}
