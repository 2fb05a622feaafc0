//! Long series in files or streams, corrected piece by piece.

use common::{Axis, Columns, Document, Recording, procedure};
use std::io;
use std::path::Path;
use tables::{Batch, Format, Reader, Writer};

use crate::noise::{self, DAY_S};
use crate::words::Tally;
use crate::{Corrected, Corrector, Error, Frame};

/// Rows that are written at once of a series that is corrected as a whole.
const PIECE_ROWS: usize = 1 << 16;

/// A table to be corrected.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// The document with calibration and model.
    pub calibration: &'a Document,
    /// Its recording of which conditions and `start` hold for the table.
    pub recording: Option<&'a str>,
    /// The frame of the field.
    pub frame: Frame,
    /// The table; None: standard input.
    pub input: Option<&'a Path>,
    /// Its format, where its name does not say it.
    pub input_format: Option<Format>,
    /// Where to; None: standard output.
    pub output: Option<&'a Path>,
    /// The format there, where the name does not say it; None: that of the input.
    pub output_format: Option<Format>,
}

/// Reads a table with `sensor_{x,y,z}_v` or `_nt`, and whatever the model's effects follow, and writes all its columns with those of
/// [`Frame::columns`]. Where every effect goes row by row, it holds no more than a few batches at a time.
///
/// # Errors
///
/// A table that cannot be read, with file and row; what [`crate::run`] refuses; a chain that has no inverse.
pub fn correct_table(request: &Request<'_>) -> Result<Tally, Error> {
    crate::check(request.calibration)?;
    let corrector = Corrector::of(request.calibration, request.frame)?;
    let template = template(request)?;
    let (reader, name, format) = open(request)?;
    let added = request.frame.columns();
    let names: Vec<String> = reader.columns().to_vec();
    // A second run replaces the columns of the first.
    let kept: Vec<usize> = (0..names.len()).filter(|k| !added.contains(&names[*k])).collect();
    let header: Vec<&str> =
        kept.iter().map(|k| names[*k].as_str()).chain(added.iter().map(String::as_str)).collect();
    let mut writer = match (request.output, request.output_format) {
        (Some(path), None) => Writer::create(path, &header)?,
        (Some(path), Some(format)) => Writer::create_as(path, format, &header)?,
        (None, told) => Writer::to_write(io::stdout(), told.unwrap_or(format), "standard output", &header)?,
    };
    let mut tally = Tally::default();
    // False: the reader of standard output has gone, and no more is wanted.
    let mut write = |recording: Recording, corrected: Corrected| -> Result<bool, Error> {
        tally.add(&corrected);
        let new = corrected.into_columns();
        let rows = recording.rows();
        for from in (0..rows).step_by(PIECE_ROWS) {
            let piece = from..(from + PIECE_ROWS).min(rows);
            let old = kept.iter().map(|k| &recording.columns[names[*k].as_str()].0);
            let columns: Vec<&[f64]> = old.chain(&new).map(|column| &column[piece.clone()]).collect();
            match writer.write(&columns) {
                Err(error) if is_closed(&error, request.output) => return Ok(false),
                written => written?,
            }
        }
        Ok(true)
    };
    let mut series = None;
    let mut whole: Option<Recording> = None;
    for batch in reader {
        let recording = recording_of(&template, &names, batch?);
        if series.is_none() {
            check_columns(request.calibration, &recording, &name)?;
            let found = recording.column("time_s").and_then(noise::length_and_step_s);
            series = Some(found.map(|[_, step_s]| [DAY_S, step_s]));
        }
        if corrector.row_by_row() {
            let corrected = corrector.correct(&recording, &name, series.flatten())?;
            if !write(recording, corrected)? {
                return Ok(tally);
            }
        } else {
            match &mut whole {
                None => whole = Some(recording),
                Some(whole) => join(whole, recording),
            }
        }
    }
    if let Some(recording) = whole {
        let corrected = corrector.correct(&recording, &name, None)?;
        if !write(recording, corrected)? {
            return Ok(tally);
        }
    }
    finish(writer, request.output)?;
    Ok(tally)
}

/// What a document says of the recording whose conditions are meant; without one, a free run.
fn template(request: &Request<'_>) -> Result<Recording, Error> {
    let Some(id) = request.recording else {
        let (id, procedure) = ("table".to_string(), procedure::FREE_RUN.to_string());
        return Ok(Recording { id, procedure, ..Recording::default() });
    };
    let found = request.calibration.recordings.iter().find(|recording| recording.id == id);
    let found = found.ok_or_else(|| {
        let ids: Vec<&str> = request.calibration.recordings.iter().map(|r| r.id.as_str()).take(30).collect();
        common::Error::Request(format!(
            "there is no recording \"{id}\" in the calibration's document; expected one of: {}",
            ids.join(", ")
        ))
    })?;
    Ok(Recording { columns: Columns::new(), table: None, ..found.clone() })
}

/// The table, its name in errors, and its format.
fn open(request: &Request<'_>) -> Result<(Reader, String, Format), Error> {
    match (request.input, request.input_format) {
        (Some(path), told) => {
            let format = told.map_or_else(|| Format::of(path), Ok)?;
            Ok((Reader::open_as(path, format, None)?, path.display().to_string(), format))
        }
        (None, Some(format)) => {
            let name = "standard input".to_string();
            Ok((Reader::from_read(io::stdin(), format, &name, None)?, name, format))
        }
        (None, None) => Err(common::Error::Request(
            "the format of standard input is not told; expected --from csv or --from ndjson, or a file"
                .into(),
        )
        .into()),
    }
}

fn recording_of(template: &Recording, names: &[String], batch: Batch) -> Recording {
    let columns = names.iter().cloned().zip(batch.columns.into_iter().map(Into::into)).collect();
    Recording { columns, ..template.clone() }
}

fn join(whole: &mut Recording, piece: Recording) {
    for (column, more) in whole.columns.values_mut().zip(piece.columns.into_values()) {
        column.0.extend(more.0);
    }
}

/// Readings of three sensors in one unit, in V with their sensitivities.
fn check_columns(document: &Document, recording: &Recording, name: &str) -> Result<(), Error> {
    if !crate::is_corrected(recording) {
        let sensors = Axis::ALL.map(|axis| format!("sensor_{axis}_v")).join(", ");
        let found: Vec<&str> = recording.columns.keys().map(String::as_str).take(30).collect();
        return Err(common::Error::Request(format!(
            "{name}: found the columns {}; expected readings of three sensors, {sensors}, or the same in nT",
            found.join(", ")
        ))
        .into());
    }
    Ok(crate::check_sensitivities(document, recording, name)?)
}

/// Writes what is left. A reader of standard output that has gone is no error.
fn finish(writer: Writer, output: Option<&Path>) -> Result<(), Error> {
    writer.finish().or_else(|error| if is_closed(&error, output) { Ok(()) } else { Err(error.into()) })
}

/// Whether the reader of standard output has gone.
fn is_closed(error: &tables::Error, output: Option<&Path>) -> bool {
    let broken = |source: &io::Error| source.kind() == io::ErrorKind::BrokenPipe;
    output.is_none() && matches!(error, tables::Error::File { source, .. } if broken(source))
}
