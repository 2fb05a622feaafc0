//! A simulation made elsewhere in the place of the prediction.

use common::Document;
use common::number::counted;

use crate::Error;
use crate::model::Model;
use crate::observed::Observed;

/// The document whose readings are off from its own prediction as they are from a simulation's readings,
/// matched by the recording's `id` and by column. Recordings that the simulation does not have are left out.
///
/// # Errors
///
/// A recording whose columns differ in length from the simulation's; no recording that both have.
pub fn against(document: &Document, simulated: &Document) -> Result<Document, Error> {
    let mut changed = document.clone();
    changed.recordings.retain(|own| simulated.recordings.iter().any(|other| other.id == own.id));
    if changed.recordings.is_empty() {
        return Err(Error::Request(format!(
            "the simulation has none of the document's recordings: it has {}, the document has {}; expected the same `id`s",
            ids(simulated),
            ids(document)
        )));
    }
    let kept = changed.clone();
    let (model, start) = Model::of(&kept, Observed::of(&kept)?)?;
    let predicted = model.predicted(&start)?;
    for channel in &model.observed.channels {
        let run = &model.observed.runs[channel.run];
        let id = &run.recording.id;
        let found = simulated.recordings.iter().find(|other| other.id == *id);
        let Some(values) = found.and_then(|other| other.column(&channel.column)) else {
            return Err(Error::document(
                format!("{}.columns.{}", run.path, channel.column),
                format!("a column that the simulation of \"{id}\" does not have"),
                "the same columns of readings in both",
            ));
        };
        if values.len() != run.recording.rows() {
            return Err(Error::document(
                format!("{}.columns.{}", run.path, channel.column),
                format!(
                    "{} where the simulation of \"{id}\" has {}",
                    counted(run.recording.rows(), "row"),
                    values.len()
                ),
                "the same rows in both, at the same times",
            ));
        }
        let recording = changed.recordings.iter_mut().find(|recording| recording.id == *id);
        let Some(column) = recording.and_then(|recording| recording.columns.get_mut(&channel.column)) else {
            continue;
        };
        for (row, predicted) in channel.rows.iter().zip(&predicted[channel.range()]) {
            column[*row] += predicted / channel.to_nt - values[*row];
        }
    }
    Ok(changed)
}

fn ids(document: &Document) -> String {
    let ids: Vec<String> = document.recordings.iter().take(5).map(|r| format!("\"{}\"", r.id)).collect();
    if ids.is_empty() { "none".into() } else { ids.join(", ") }
}
