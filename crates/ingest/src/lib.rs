//! Files of observatories and loggers into a document: IAGA-2002, IAF, IMF, IBF, CDF, CSV, NDJSON and Parquet.
//!
//! [`run`] reads files of one series, brings their times to UTC and their values to the document's units,
//! joins them in the order of time and adds them as one recording. A long series goes beside the document as
//! a [`Table`]. Nothing is written here.
//!
//! The content of a file decides what it is (`tables::Content`). `iaga`, `observatory`, `imagcdf`,
//! `cdf`, `delimited`, `ndjson` and `parquet` each give a `Piece`: moments in whole nanoseconds, columns in the
//! document's units, and the line of each row, so that every later fault can name its place. Text is parsed
//! in parts of a megabyte on all cores; the first fault by line counts. `raw` applies what a mapping says of
//! values before they are converted (fill values, two's complement, valid range), for all formats alike.
//! `series` joins pieces, sorting only where they overlap; `recording` makes the document's part of them.
//! Sheets of absolute measurements are no pieces of a series: `sheets` makes a recording of each.
//!
//! A mapping is data (`mapping`, with a schema). `guess` writes one, and also reads a file that has none:
//! what it would have to guess is then an error. A series is held in memory, since it may have to be sorted.
//! `program::beside::write` writes the text of the document, gives the table its name, and then the document.

mod cdf;
mod clock;
mod delimited;
mod fill;
mod guess;
mod iaga;
mod imagcdf;
mod jumps;
mod mapping;
mod nasa;
mod ndjson;
mod number;
mod observatory;
mod parquet;
mod parts;
mod piece;
mod raw;
mod recording;
mod series;
mod sheets;
mod text;
mod times;
mod units;
mod words;

pub use common::Error;
pub use guess::{Guess, guess};
pub use mapping::{ColumnMapping, Mapping, SourceColumn, TimeMapping};
pub use nasa::{LAST_LEAP, tt2000};
pub use program::beside::{INLINE_ROWS, Table};
pub use recording::Ingested;

use common::Document;
use std::path::PathBuf;

use piece::Piece;
use tables::Content;
use text::Source;

/// What was asked for.
#[derive(Clone, Debug)]
pub struct Options {
    /// How files of columns are read; None: as they themselves say, where they do.
    pub mapping: Option<Mapping>,
    /// What vector readings are: `sensor`, `reference`, `test`, …
    pub quantity: String,
    /// The recording's id; None: of the station or the first file, and the day.
    pub id: Option<String>,
    /// The recording's procedure.
    pub procedure: String,
    /// Which file counts where they disagree; None: that is an error.
    pub keep: Option<Keep>,
    /// Whether rows may stand in any order within a file.
    pub sort: bool,
    /// Whether rows count where a header contradicts them.
    pub trust_rows: bool,
    /// Is added to D of IAGA-2002, minutes of arc; None: as the file's comment DECBAS says.
    pub declination_base_arcmin: Option<f64>,
    /// Where readings go.
    pub readings: Readings,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            mapping: None,
            quantity: "sensor".into(),
            id: None,
            procedure: common::procedure::FREE_RUN.into(),
            keep: None,
            sort: false,
            trust_rows: false,
            declination_base_arcmin: None,
            readings: Readings::ByLength,
        }
    }
}

/// Which of several files counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// The one that begins first.
    First,
    /// The one that begins last.
    Last,
}

/// Where a recording's readings go.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Readings {
    /// Into the document up to [`INLINE_ROWS`] rows, beside it otherwise.
    ByLength,
    /// Into the document.
    Inline,
    /// Beside it; the table's relative path, or one made of the recording's id.
    Beside(Option<String>),
}

/// Adds files of one series to a document as a recording, or sheets of absolute measurements as one each.
///
/// # Errors
///
/// What cannot be read, with file, line and column; files that do not belong together; readings whose unit is
/// not stated.
pub fn run(document: Document, files: &[PathBuf], options: &Options) -> Result<Ingested, Error> {
    let mut pieces = Vec::with_capacity(files.len());
    let mut sheets = Vec::new();
    for file in files {
        let source = Source::read(file)?;
        if options.mapping.is_none()
            && let Some(measured) = sheets::read(&source)?
        {
            sheets.extend(measured);
            continue;
        }
        let (piece, sha256) = rayon::join(|| read(&source, options), || source.sha256());
        pieces.push(Piece { sha256, ..piece? });
    }
    if !sheets.is_empty() {
        let Some(piece) = pieces.first() else { return sheets::add(document, sheets, options) };
        let message = "holds no absolute measurement as the other files do; ingest the series by itself, then join both with --add";
        return Err(Error::Request(format!("{} {message}", piece.shown)));
    }
    let (series, pieces) = series::join(pieces, options.keep, options.sort)?;
    recording::add(document, series, pieces, options)
}

/// What one file says.
fn read(source: &Source, options: &Options) -> Result<Piece, Error> {
    if options.mapping.is_none() {
        let says_itself = match source.kind {
            Content::Cdf => imagcdf::read(source, options)?,
            _ => observatory::read(source, options)?,
        };
        if let Some(piece) = says_itself {
            return Ok(piece);
        }
    }
    if source.kind.is_observatory() {
        if options.mapping.is_some() {
            let name = source.kind.name();
            let expected = format!(
                "no --map, which is for CDF, CSV, NDJSON and Parquet: {name} describes its own columns"
            );
            return Err(source.fault(tables::Place::Whole, name, expected));
        }
        return iaga::read(source, options);
    }
    let (mapping, notes) = match &options.mapping {
        Some(mapping) => (mapping.clone(), Vec::new()),
        None => guess::certain(source, &options.quantity)?,
    };
    let named = matches!(source.kind, Content::NdJson | Content::Parquet | Content::Cdf);
    if let Some(number) = mapping.number().filter(|_| named) {
        let found = format!("a mapping that takes column {number}");
        let expected = "names of columns, which such a file has, in the mapping";
        return Err(source.fault(tables::Place::Whole, found, expected));
    }
    let mut piece = match source.kind {
        Content::NdJson => ndjson::read(source, &mapping)?,
        Content::Parquet => parquet::read(source, &mapping)?,
        Content::Cdf => cdf::read(source, &mapping)?,
        Content::Delimited | Content::Iaga | Content::Iaf | Content::Document => {
            delimited::read(source, &mapping)?
        }
    };
    piece.header.insert("mapping".into(), serde_json::to_value(&mapping).unwrap_or_default());
    piece.notes.extend(notes);
    Ok(piece)
}
