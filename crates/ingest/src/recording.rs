//! A series as a recording of a document, and the table beside it.

use common::{Column, Columns, Document, Extra, Recording};
use program::beside::{INLINE_ROWS, Table, file_name};
use serde_json::{Value, json};
use std::path::Path;

use crate::clock::{self, Clock, SECOND_NS};
use crate::jumps::{Jump, jumps};
use crate::piece::Piece;
use crate::series::{Gaps, Series, gaps, step_s};
use crate::{Error, Options, Readings, words};

/// What came of files.
#[derive(Debug)]
pub struct Ingested {
    /// The document with the recording.
    pub document: Document,
    /// The readings, where they go beside it.
    pub table: Option<Table>,
    /// Words for people.
    pub words: String,
}

/// Adds a series to a document.
pub fn add(
    mut document: Document,
    series: Series,
    pieces: Vec<Piece>,
    options: &Options,
) -> Result<Ingested, Error> {
    let first_ns = series.times_ns.first().copied().unwrap_or(0);
    let begin_ns = if series.clock == Clock::Utc { first_ns } else { 0 };
    let step_s = if series.clock == Clock::None { None } else { step_s(&series.times_ns) };
    let gaps = step_s.map_or_else(Gaps::default, |step_s| gaps(&series.times_ns, begin_ns, step_s));
    let start = (series.clock == Clock::Utc).then(|| clock::text(first_ns));
    let id = options.id.clone().unwrap_or_else(|| id(&pieces, start.as_deref()));
    if let Some(index) = document.recordings.iter().position(|known| known.id == id) {
        let found = format!("\"{id}\" there already");
        let expected = "another id for the new recording; set it with --id";
        return Err(Error::document(format!("recordings[{index}].id"), found, expected));
    }
    let jumps = jumps(&series, begin_ns);
    let words = words::words(&series, &pieces, &gaps, &jumps, step_s, start.as_deref(), &id);
    let jumps: Vec<Jump> = jumps.into_iter().map(|(jump, _)| jump).collect();
    let source = source(&series, &pieces, step_s, &gaps, &jumps);
    let rows = series.times_ns.len();
    let mut columns = Vec::with_capacity(1 + series.columns.len());
    if series.clock != Clock::None {
        let times = series.times_ns.iter().map(|time| (time - begin_ns) as f64 / SECOND_NS as f64);
        columns.push(("time_s".to_string(), times.collect()));
    }
    columns.extend(series.columns);
    let table = match &options.readings {
        Readings::Inline => None,
        Readings::ByLength if rows <= INLINE_ROWS => None,
        Readings::ByLength | Readings::Beside(None) => Some(file_name(&id)),
        Readings::Beside(Some(path)) => Some(path.clone()),
    };
    let mut recording = Recording {
        id,
        procedure: options.procedure.clone(),
        start,
        table: table.clone(),
        extra: Extra::from_iter([("source".to_string(), source)]),
        ..Recording::default()
    };
    // The axes of a sensor along H and E are those of a variometer.
    let letters = pieces.first().and_then(|piece| piece.header.get("components")?.as_str());
    if letters.is_some_and(|letters| letters.contains('H') && letters.contains('E')) {
        recording.conditions.extra.insert("components".into(), "hez".into());
    }
    let table = match table {
        Some(path) => Some(Table { path, columns }),
        None => {
            recording.columns =
                columns.into_iter().map(|(name, values)| (name, Column::from(values))).collect::<Columns>();
            None
        }
    };
    document.recordings.push(recording);
    document.check()?;
    let beside = table.as_ref().map(|table| format!("\n  readings beside the document: {}", table.path));
    Ok(Ingested { document, table, words: words + &beside.unwrap_or_default() })
}

/// Of the station or the first file, and the day where the file's name does not say it.
fn id(pieces: &[Piece], start: Option<&str>) -> String {
    let Some(first) = pieces.first() else { return "recording".into() };
    match (&first.station, start) {
        (Some(station), Some(start)) => {
            format!("{}-{}", station.to_lowercase(), &start[..start.len().min(10)])
        }
        _ => {
            let stem = Path::new(&first.name).file_stem();
            stem.map_or_else(|| "recording".into(), |stem| stem.to_string_lossy().into_owned())
        }
    }
}

/// Where the readings come from, as the document keeps it.
fn source(series: &Series, pieces: &[Piece], step_s: Option<f64>, gaps: &Gaps, jumps: &[Jump]) -> Value {
    let file = |piece: &Piece| json!({"name": piece.name, "rows": piece.lines.len(), "sha256": piece.sha256});
    let files: Vec<Value> = pieces.iter().map(file).collect();
    let mut source = Extra::new();
    source.insert("format".into(), pieces.first().map_or("", |piece| piece.format).into());
    source.insert("files".into(), files.into());
    if let Some(first) = pieces.first() {
        source.extend(first.header.clone());
    }
    if let Some(step_s) = step_s {
        source.insert("step_s".into(), step_s.into());
    }
    source.insert("gaps".into(), json!(gaps));
    if !jumps.is_empty() {
        source.insert("jumps".into(), json!(jumps));
    }
    for (key, count) in [
        ("merged_rows", series.merged),
        ("disagreeing_rows", series.disagreeing),
        ("sorted_rows", series.sorted),
    ] {
        if count > 0 {
            source.insert(key.into(), count.into());
        }
    }
    source.into()
}
