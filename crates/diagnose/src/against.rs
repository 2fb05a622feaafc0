//! A simulation made elsewhere in the place of the prediction.

use common::number::counted;
use common::{Axis, Document, Recording, procedure};

use crate::Error;
use crate::model::Model;
use crate::observed::Observed;

/// The document's recordings that the simulation has too, by `id`.
fn matched(document: &Document, simulated: &Document) -> Result<Document, Error> {
    let mut matched = document.clone();
    matched.recordings.retain(|own| simulated.recordings.iter().any(|other| other.id == own.id));
    if matched.recordings.is_empty() {
        return Err(Error::Request(format!(
            "the simulation has none of the document's recordings: it has {}, the document has {}; expected the same `id`s",
            ids(simulated),
            ids(document)
        )));
    }
    Ok(matched)
}

/// The simulation's column of a recording.
fn column<'s>(
    simulated: &'s Document,
    (path, recording): (&str, &Recording),
    name: &str,
) -> Result<&'s [f64], Error> {
    let id = &recording.id;
    let found = simulated.recordings.iter().find(|other| other.id == *id);
    let path = || format!("{path}.columns.{name}");
    let Some(values) = found.and_then(|other| other.column(name)) else {
        let what = format!("a column that the simulation of \"{id}\" does not have");
        return Err(Error::document(path(), what, "the same columns of readings in both"));
    };
    if values.len() != recording.rows() {
        let rows = counted(recording.rows(), "row");
        let what = format!("{rows} where the simulation of \"{id}\" has {}", values.len());
        return Err(Error::document(path(), what, "the same rows in both, at the same times"));
    }
    Ok(values)
}

/// The document whose readings are off from its own prediction as they are from a simulation's readings, matched by
/// the recording's `id` and by column. Recordings that the simulation does not have are left out.
///
/// # Errors
///
/// A recording whose columns differ in length from the simulation's; no recording that both have.
pub fn against(document: &Document, simulated: &Document) -> Result<Document, Error> {
    let kept = matched(document, simulated)?;
    let mut changed = kept.clone();
    let (model, start) = Model::of(Observed::of(&kept)?)?;
    let predicted = model.predicted(&start)?;
    for channel in &model.observed.channels {
        let run = &model.observed.runs[channel.run];
        let values = column(simulated, (&run.path, run.recording), &channel.column)?;
        let recording = changed.recordings.iter_mut().find(|recording| recording.id == run.recording.id);
        let Some(column) = recording.and_then(|recording| recording.columns.get_mut(&channel.column)) else {
            continue;
        };
        for (row, predicted) in channel.rows.iter().zip(&predicted[channel.range()]) {
            column[*row] += predicted / channel.to_nt - values[*row];
        }
    }
    Ok(changed)
}

/// The instruments side by side as if the one were off from the other, in equal axes, as its readings are from a
/// simulation's: without calibration and model, which the simulation has.
///
/// # Errors
///
/// As [`against`]; a simulation whose readings are those of the document.
pub fn pairs(document: &Document, simulated: &Document) -> Result<Document, Error> {
    let mut changed = matched(document, simulated)?;
    (changed.calibration, changed.model) = (None, None);
    changed.recordings.retain(|recording| recording.procedure == procedure::DIFFERENTIAL);
    for recording in &mut changed.recordings {
        let index = document.recordings.iter().position(|own| own.id == recording.id).unwrap_or(0);
        for axis in Axis::ALL {
            let name = format!("test_{axis}_nt");
            let reference = recording.column(&format!("reference_{axis}_nt")).map(<[f64]>::to_vec);
            let (Some(reference), Some(_)) = (reference, recording.column(&name)) else { continue };
            let values = column(simulated, (&format!("recordings[{index}]"), recording), &name)?;
            let Some(test) = recording.columns.get_mut(&name) else { continue };
            if test[..] == *values {
                return Err(Error::document(
                    format!("recordings[{index}].columns.{name}"),
                    "the readings of the simulation that --against names",
                    "readings of an instrument, and a simulation of them",
                ));
            }
            let both = reference.iter().zip(values);
            test.iter_mut().zip(both).for_each(|(test, (reference, value))| *test += reference - value);
        }
    }
    Ok(changed)
}

fn ids(document: &Document) -> String {
    let ids: Vec<String> = document.recordings.iter().take(5).map(|r| format!("\"{}\"", r.id)).collect();
    if ids.is_empty() { "none".into() } else { ids.join(", ") }
}
