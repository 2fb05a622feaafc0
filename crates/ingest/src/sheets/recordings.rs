//! Measurements as recordings of a document.

use common::number::counted;
use common::{Column, Columns, Document, Extra, Recording, procedure};
use serde_json::json;

use super::Sheet;
use super::row::COLUMNS;
use crate::clock::{self, SECOND_NS};
use crate::recording::Ingested;
use crate::{Error, Options, Readings};

/// Adds measurements to a document, in the order of time. Errors: an id that the document has already; a
/// table beside it, which they do not need.
pub fn add(mut document: Document, mut sheets: Vec<Sheet>, options: &Options) -> Result<Ingested, Error> {
    if matches!(options.readings, Readings::Beside(_)) {
        let message = "--beside: absolute measurements have few rows and stay in the document; leave it out";
        return Err(Error::Request(message.into()));
    }
    sheets.sort_by_key(start_ns);
    let several = sheets.len() > 1;
    let mut words = Vec::new();
    for sheet in sheets {
        let moment = clock::text(start_ns(&sheet));
        let mut id = format!("{}-{}{}", &moment[..10], &moment[11..13], &moment[14..16]);
        if let Some(given) = &options.id {
            id = if several { format!("{given}-{id}") } else { given.clone() };
        }
        let is_known = |id: &str| document.recordings.iter().any(|known| known.id == id);
        if let Some(pillar) = sheet.conditions.get("pillar").and_then(|pillar| pillar.as_str())
            && is_known(&id)
        {
            id = format!("{id}-{pillar}");
        }
        if is_known(&id) {
            let found = format!("a second recording \"{id}\", from {}", sheet.file);
            let expected = "each measurement once; set another id with --id where it is another one";
            return Err(Error::document("recordings", found, expected));
        }
        words.push(said(&id, &sheet));
        document.recordings.push(recording(id, sheet));
    }
    document.check()?;
    Ok(Ingested { document, table: None, words: words.join("\n") })
}

fn start_ns(sheet: &Sheet) -> i64 {
    let positions = sheet.rows.iter().filter(|row| !["", "Mark"].contains(&row.view));
    positions.filter_map(|row| row.time_ns).min().unwrap_or(0)
}

fn recording(id: String, sheet: Sheet) -> Recording {
    let start_ns = start_ns(&sheet);
    let mut rows = sheet.rows;
    // A document's times do not run backwards; readings without one stay in front.
    rows.sort_by_key(|row| row.time_ns);
    let seconds = |time_ns: i64| time_ns.saturating_sub(start_ns) as f64 / SECOND_NS as f64;
    let times: Vec<f64> = rows.iter().map(|row| row.time_ns.map_or(f64::NAN, seconds)).collect();
    let mut columns = Columns::from_iter([("time_s".to_string(), Column::from(times))]);
    for (index, name) in COLUMNS.iter().enumerate() {
        let values: Vec<f64> = rows.iter().map(|row| row.values[index]).collect();
        // The first four are of the theodolite.
        if index < 4 || values.iter().any(|value| !value.is_nan()) {
            columns.insert(name.to_string(), Column::from(values));
        }
    }
    let file = json!({"name": sheet.file, "rows": rows.len(), "sha256": sheet.sha256});
    let mut source =
        Extra::from_iter([("format".into(), sheet.format.into()), ("files".into(), json!([file]))]);
    source.extend(sheet.kept);
    let (procedure, start) = (procedure::ABSOLUTE.into(), Some(clock::text(start_ns)));
    let extra = Extra::from_iter([("source".to_string(), source.into())]);
    let mut recording = Recording { id, procedure, start, columns, extra, ..Recording::default() };
    recording.conditions.extra = sheet.conditions;
    recording
}

/// What was read, and what was made of it.
fn said(id: &str, sheet: &Sheet) -> String {
    let of = |views: &[&str]| sheet.rows.iter().filter(|row| views.contains(&row.view)).count();
    let marks = counted(of(&["Mark"]), "reading");
    let (level, other) = (of(&["East", "West"]), of(&["North", "South"]));
    let scalars = sheet.rows.iter().filter(|row| !row.values[4].is_nan()).count();
    let scalars = if scalars > 0 { format!(", {scalars} of F") } else { String::new() };
    let (file, format, notes) = (&sheet.file, sheet.format, sheet.notes.iter());
    let first = format!(
        "ingest: \"{id}\" from {file} ({format}): {marks} of the mark, {level} of the declination, {other} of the inclination{scalars}"
    );
    notes.fold(first, |words, note| format!("{words}\n  {note}"))
}
