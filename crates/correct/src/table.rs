//! Long series in files or streams, corrected piece by piece.

use common::{Axis, Column, Columns, Document, Recording, procedure, range};
use rayon::prelude::*;
use std::io;
use std::path::Path;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread;
use tables::{BATCH_ROWS, Batch, Format, Reader, Writer};

use crate::formats::{Station, Written};
use crate::noise::{self, DAY_S};
use crate::words::Tally;
use crate::{Corrected, Corrector, Error, Frame, variometer};

/// Rows that are written at once of a series that is corrected as a whole.
const PIECE_ROWS: usize = 1 << 16;
/// Rows that are corrected at once where each stands for itself: as many as a processor's cache holds with
/// all their derivatives.
const ROWS_AT_ONCE: usize = 1 << 10;

/// A table to be corrected.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// The document with calibration and model.
    pub calibration: &'a Document,
    /// Its recording of which conditions and `start` hold for the table.
    pub recording: Option<&'a str>,
    /// The frame of the field.
    pub frame: Frame,
    /// Readings that were read already, in place of the table. When they were taken counts before what
    /// `recording` says.
    pub readings: Option<&'a Recording>,
    /// The table; None: standard input.
    pub input: Option<&'a Path>,
    /// Its format, where its name does not say it.
    pub input_format: Option<Format>,
    /// Where to; None: standard output.
    pub output: Option<&'a Path>,
    /// The format there, where the name does not say it; None: that of the input.
    pub output_format: Option<Format>,
    /// For whom a format of observatories is written instead, which is in [`Frame::Geo`].
    pub station: Option<Station<'a>>,
}

impl<'a> Request<'a> {
    /// A table on standard input, corrected in SEN to standard output.
    pub fn of(calibration: &'a Document) -> Self {
        Self {
            calibration,
            recording: None,
            frame: Frame::Sen,
            readings: None,
            input: None,
            input_format: None,
            output: None,
            output_format: None,
            station: None,
        }
    }
}

enum Sheet {
    Table(Writer),
    Observatory(Written),
}

/// Reads a table with `sensor_{x,y,z}_v` or `_nt`, and whatever the model's effects follow, and writes all
/// its columns with those of [`Frame::columns`]. Where every effect goes row by row, it holds no more than a
/// few batches at a time.
/// Errors: a table that cannot be read, with file and row; what [`crate::run`] refuses; a chain that has no inverse.
pub fn correct_table(request: &Request<'_>) -> Result<Tally, Error> {
    crate::check(request.calibration)?;
    let template = template(request)?;
    let frame = variometer::frame(request.calibration, &template, request.frame);
    let request = &Request { frame, ..*request };
    let corrector = Corrector::of(request.calibration, frame)?;
    let (table, batches) = open(request)?;
    let no_rows = Batch { first_row: 0, columns: vec![Vec::new(); table.names.len()] };
    check_columns(request.calibration, &recording_of(&template, &table.names, no_rows), &table.name)?;
    let mut output = Output { request, table: &table, sheet: None, tally: Tally::default() };
    let pieces = Pieces { corrector: &corrector, template: &template, table: &table };
    // Rows are corrected while those before them are written.
    thread::scope(|scope| {
        let (ready, corrected) = sync_channel(1);
        scope.spawn(move || pieces.correct(batches, &ready));
        for piece in corrected {
            let (recording, corrected) = piece?;
            if !output.write(&recording, corrected)? {
                return Ok(output.tally);
            }
        }
        output.finish(&template)
    })
}

type Piece = Result<(Recording, Corrected), Error>;

struct Pieces<'a> {
    corrector: &'a Corrector<'a>,
    template: &'a Recording,
    table: &'a Table,
}

impl Pieces<'_> {
    /// Hands on the pieces in their order, until an error or until none is wanted any more. A table that has
    /// to be corrected as a whole is one piece.
    fn correct(self, batches: Batches<'_>, ready: &SyncSender<Piece>) {
        let mut series = None;
        let mut whole: Option<Recording> = None;
        for batch in batches {
            let piece = match self.read(batch) {
                Ok(recording) if !self.corrector.row_by_row() => {
                    match &mut whole {
                        None => whole = Some(recording),
                        Some(whole) => {
                            let columns = whole.columns.values_mut().zip(recording.columns.into_values());
                            columns.for_each(|(column, more)| column.extend(&more));
                        }
                    }
                    continue;
                }
                Ok(recording) => self.rows(recording, &mut series),
                Err(error) => Err(error),
            };
            let failed = piece.is_err();
            if ready.send(piece).is_err() || failed {
                return;
            }
        }
        if let Some(recording) = whole {
            let corrected = self.corrector.correct(&recording, &self.table.name, None);
            // Where nobody waits for it any more, it is not wanted.
            let _ = ready.send(corrected.map(|corrected| (recording, corrected)));
        }
    }

    fn read(&self, batch: Result<Batch, tables::Error>) -> Result<Recording, Error> {
        let batch = batch?;
        let Table { names, name, .. } = self.table;
        let columns = names.iter().map(String::as_str).zip(batch.columns.iter().map(Vec::as_slice));
        range::rows(name, batch.first_row, columns)?;
        Ok(recording_of(self.template, names, batch))
    }

    /// Corrects rows that stand each for itself. `series` is the length and step, s, that the first of them
    /// determine.
    fn rows(&self, recording: Recording, series: &mut Option<Option<[f64; 2]>>) -> Piece {
        let step = || recording.column("time_s").and_then(noise::length_and_step_s);
        let series = *series.get_or_insert_with(|| step().map(|[_, step_s]| [DAY_S, step_s]));
        let corrected: Vec<Corrected> = (0..recording.rows().div_ceil(ROWS_AT_ONCE))
            .into_par_iter()
            .map(|number| {
                self.corrector.correct(&piece(self.template, &recording, number), &self.table.name, series)
            })
            .collect::<Result<_, Error>>()?;
        Ok((recording, Corrected::joined(corrected)))
    }
}

/// Where corrected rows go. It is opened when the first of them are there, so that what is refused leaves
/// nothing behind.
struct Output<'a> {
    request: &'a Request<'a>,
    table: &'a Table,
    sheet: Option<Sheet>,
    tally: Tally,
}

impl Output<'_> {
    /// The columns of the input that are written on: a second run replaces those that the first one added.
    fn kept(&self) -> Vec<&str> {
        let added = self.request.frame.columns();
        self.table
            .names
            .iter()
            .map(String::as_str)
            .filter(|name| !added.iter().any(|new| new == name))
            .collect()
    }

    fn open(&self, recording: &Recording) -> Result<Sheet, Error> {
        if let Some(station) = self.request.station {
            let is_adjusted = variometer::is_by_baselines(self.request.calibration, recording);
            let written = Written::create(self.request.output, station, recording, is_adjusted)?;
            return Ok(Sheet::Observatory(written));
        }
        let added = self.request.frame.columns();
        let mut header = self.kept();
        header.extend(added.iter().map(String::as_str));
        Ok(Sheet::Table(match (self.request.output, self.request.output_format) {
            (Some(path), None) => Writer::create(path, &header)?,
            (Some(path), Some(format)) => Writer::create_as(path, format, &header)?,
            (None, told) => {
                Writer::to_write(io::stdout(), told.unwrap_or(self.table.format), "standard output", &header)?
            }
        }))
    }

    /// Writes rows. False: the reader of standard output has gone, and no more is wanted.
    fn write(&mut self, recording: &Recording, corrected: Corrected) -> Result<bool, Error> {
        self.tally.add(&corrected);
        let mut sheet = match self.sheet.take() {
            Some(sheet) => sheet,
            None => self.open(recording)?,
        };
        let wanted = match &mut sheet {
            Sheet::Table(writer) => self.write_table(writer, recording, corrected)?,
            Sheet::Observatory(writer) => writer.write(recording, &corrected)?,
        };
        self.sheet = wanted.then_some(sheet);
        Ok(wanted)
    }

    fn write_table(
        &self,
        writer: &mut Writer,
        recording: &Recording,
        corrected: Corrected,
    ) -> Result<bool, Error> {
        let new = corrected.into_columns();
        let old = self.kept().into_iter().filter_map(|name| recording.column(name));
        let columns: Vec<&[f64]> = old.chain(new.iter().map(Vec::as_slice)).collect();
        for from in (0..recording.rows()).step_by(PIECE_ROWS) {
            let piece = from..(from + PIECE_ROWS).min(recording.rows());
            let columns: Vec<&[f64]> = columns.iter().map(|column| &column[piece.clone()]).collect();
            match writer.write(&columns) {
                Err(error) if is_closed(&error, self.request.output) => return Ok(false),
                written => written?,
            }
        }
        Ok(true)
    }

    /// Writes what is left, and of a table without rows its header. A reader of standard output that has gone
    /// is no error.
    fn finish(mut self, template: &Recording) -> Result<Tally, Error> {
        let sheet = match self.sheet.take() {
            Some(sheet) => sheet,
            None if self.tally.is_empty() => self.open(template)?,
            None => return Ok(self.tally),
        };
        match sheet {
            Sheet::Observatory(writer) => writer.finish()?,
            Sheet::Table(writer) => match writer.finish() {
                Err(error) if !is_closed(&error, self.request.output) => return Err(error),
                _ => {}
            },
        }
        Ok(self.tally)
    }
}

/// What a document says of the recording whose conditions are meant; without one, a free run.
fn template(request: &Request<'_>) -> Result<Recording, Error> {
    let start = request.readings.and_then(|readings| readings.start.clone());
    let Some(id) = request.recording else {
        let (id, procedure) = ("table".to_string(), procedure::FREE_RUN.to_string());
        let conditions = request.readings.map(|readings| readings.conditions.clone()).unwrap_or_default();
        return Ok(Recording { id, procedure, start, conditions, ..Recording::default() });
    };
    let found = request.calibration.recordings.iter().find(|recording| recording.id == id);
    let found = found.ok_or_else(|| {
        let ids: Vec<&str> = request.calibration.recordings.iter().map(|r| r.id.as_str()).take(30).collect();
        Error::Request(format!(
            "there is no recording \"{id}\" in the calibration's document; expected one of: {}",
            ids.join(", ")
        ))
    })?;
    let start = start.or(found.start.clone());
    Ok(Recording { columns: Columns::new(), table: None, start, ..found.clone() })
}

type Batches<'a> = Box<dyn Iterator<Item = Result<Batch, tables::Error>> + Send + 'a>;

struct Table {
    names: Vec<String>,
    /// As errors call it.
    name: String,
    format: Format,
}

fn open<'a>(request: &Request<'a>) -> Result<(Table, Batches<'a>), Error> {
    let stdin = "standard input".to_string();
    if let Some(readings) = request.readings {
        let name = request.input.map_or(stdin, |path| path.display().to_string());
        let names = readings.columns.keys().cloned().collect();
        let batch = move |first: usize| {
            let rows = first..(first + BATCH_ROWS).min(readings.rows());
            let columns = readings.columns.values().map(|column| column[rows.clone()].to_vec()).collect();
            Ok(Batch { first_row: first as u64, columns })
        };
        let batches = Box::new((0..readings.rows()).step_by(BATCH_ROWS).map(batch));
        return Ok((Table { names, name, format: Format::Csv }, batches));
    }
    let (reader, name, format) = match (request.input, request.input_format) {
        (Some(path), told) => {
            let format = told.map_or_else(|| Format::of(path), Ok)?;
            (Reader::open_as(path, format, None)?, path.display().to_string(), format)
        }
        (None, Some(format)) => (Reader::from_read(io::stdin(), format, &stdin, None)?, stdin, format),
        (None, None) => {
            let unknown =
                "the format of standard input is unknown; expected --from csv or --from ndjson, or a file";
            return Err(Error::Request(unknown.into()));
        }
    };
    Ok((Table { names: reader.columns().to_vec(), name, format }, Box::new(reader)))
}

fn recording_of(template: &Recording, names: &[String], batch: Batch) -> Recording {
    let columns = names.iter().cloned().zip(batch.columns.into_iter().map(Into::into)).collect();
    Recording { columns, ..template.clone() }
}

/// The rows of a recording that are corrected at once, by number.
fn piece(template: &Recording, recording: &Recording, number: usize) -> Recording {
    let rows = number * ROWS_AT_ONCE..((number + 1) * ROWS_AT_ONCE).min(recording.rows());
    let cut =
        |(name, column): (&String, &Column)| (name.clone(), Column::from(column[rows.clone()].to_vec()));
    let columns = recording.columns.iter().map(cut).collect();
    Recording { columns, ..template.clone() }
}

/// Readings of three sensors in one unit, in V with their sensitivities.
fn check_columns(document: &Document, recording: &Recording, name: &str) -> Result<(), Error> {
    if !crate::is_corrected(recording) {
        let sensors = Axis::ALL.map(|axis| format!("sensor_{axis}_v")).join(", ");
        let found: Vec<&str> = recording.columns.keys().map(String::as_str).take(30).collect();
        let found = found.join(", ");
        return Err(Error::Request(format!(
            "{name}: found the columns {found}; expected readings of three sensors, {sensors}, or the same in nT; for other names write a mapping: ingest guess {name} > map.json, then correct --map map.json"
        )));
    }
    if variometer::is_by_baselines(document, recording) {
        return Ok(());
    }
    crate::check_sensitivities(document, recording, name)
}

/// Whether the reader of standard output has gone.
fn is_closed(error: &tables::Error, output: Option<&Path>) -> bool {
    let broken = |source: &io::Error| source.kind() == io::ErrorKind::BrokenPipe;
    output.is_none() && matches!(error, tables::Error::File { source, .. } if broken(source))
}
