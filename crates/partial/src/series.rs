//! Files of a series, which become pieces: tables, and recordings of documents.

use common::{Document, Error as Fault, Recording, range};
use std::fs::{self, File};
use std::io::{Cursor, Read};
use std::path::Path;
use tables::{Content, Format, Reader};

use crate::{Partial, merge};

/// Bytes of a stream that are read to see its format and its columns.
const HEAD: u64 = 1 << 20;

/// How a stage makes statistics of the rows of a series.
pub trait Series: Clone + Sync {
    /// The statistics.
    type Partial: Partial;
    /// What takes rows.
    type Take: Take<Partial = Self::Partial>;
    /// The procedure whose recordings of a document are taken.
    const PROCEDURE: &'static str;

    /// How the rows of a recording are taken, by what it states; None where it is not of the series.
    ///
    /// Errors: what it states that cannot be.
    fn of_recording(&self, _recording: &Recording, _path: &str) -> Result<Option<Self>, Fault> {
        Ok(Some(self.clone()))
    }

    /// The columns that are wanted of those that there are, times first, and what takes them.
    ///
    /// Errors: what is missing, in words.
    fn begin(&self, there: &[String]) -> Result<(Vec<String>, Self::Take), String>;
}

/// Takes a series batch by batch.
pub trait Take {
    /// What comes of it.
    type Partial: Partial;

    /// Takes the next rows, in the order of the names that were wanted.
    ///
    /// Errors: rows that cannot be taken, by their number.
    fn push(&mut self, columns: &[&[f64]]) -> Result<(), <Self::Partial as Partial>::Error>;

    /// The piece.
    ///
    /// Errors: where there is none.
    fn finish(self) -> Result<Self::Partial, <Self::Partial as Partial>::Error>;
}

/// Takes a file in one pass and bounded memory: CSV, NDJSON or Parquet by its extension, `.json` a document,
/// of which the recordings of the procedure are taken, with times since 1970 where they say when they began.
///
/// Errors: a file that cannot be read, or rows that cannot be taken, each with file and row.
pub fn take<S: Series>(series: &S, path: &Path) -> Result<S::Partial, Fault> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
        let text = fs::read_to_string(path).map_err(|source| Fault::file(path, "read", source))?;
        return document(series, path, &text);
    }
    table(series, path, 0.0)
}

/// Takes what comes from a stream, in one pass: CSV, NDJSON or a document, told by how it begins. `shown`
/// stands for it in messages.
///
/// Errors: as [`take`].
pub fn take_from<S: Series>(
    series: &S,
    mut input: impl Read + Send + 'static,
    shown: &str,
) -> Result<S::Partial, Fault> {
    let failed = |source| Fault::file(shown, "read", source);
    let mut head = Vec::new();
    input.by_ref().take(HEAD).read_to_end(&mut head).map_err(failed)?;
    let format = match Content::of(shown, &head)? {
        Content::Delimited => Format::Csv,
        Content::NdJson => Format::NdJson,
        Content::Document => {
            input.read_to_end(&mut head).map_err(failed)?;
            let text = String::from_utf8(head).map_err(|_| {
                Fault::Request(format!("{shown}: found bytes that are not UTF-8; expected JSON"))
            })?;
            return document(series, Path::new(shown), &text);
        }
        other => {
            return Err(Fault::Request(format!(
                "{shown}: found {}; expected CSV, NDJSON or a document, or this as a file",
                other.name()
            )));
        }
    };
    // Whole lines of it tell the columns.
    let lines = head.iter().rposition(|byte| *byte == b'\n').map_or(head.len(), |end| end + 1);
    let there = Reader::from_read(Cursor::new(head[..lines].to_vec()), format, shown, None)?;
    let there = there.columns().to_vec();
    let open = |names: &[&str]| Reader::from_read(Cursor::new(head).chain(input), format, shown, Some(names));
    rows(series, shown, &there, open, 0.0)
}

fn table<S: Series>(series: &S, path: &Path, start_s: f64) -> Result<S::Partial, Fault> {
    let there = columns(path)?;
    rows(series, &path.display().to_string(), &there, |names| Reader::open(path, Some(names)), start_s)
}

/// Takes the rows of the columns that are wanted.
fn rows<S: Series>(
    series: &S,
    shown: &str,
    there: &[String],
    open: impl FnOnce(&[&str]) -> Result<Reader, tables::Error>,
    start_s: f64,
) -> Result<S::Partial, Fault> {
    let of_file = |reason: String| Fault::Request(format!("{shown}: {reason}"));
    let refused = |error| of_file(told::<S>(error));
    let (names, mut taking) = series.begin(there).map_err(|missing| {
        of_file(format!("found the columns {}; expected {missing} among them", there.join(", ")))
    })?;
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    for batch in open(&names)? {
        let mut batch = batch?;
        let columns = names.iter().copied().zip(batch.columns.iter().map(Vec::as_slice));
        range::rows(shown, batch.first_row, columns)?;
        if start_s != 0.0 {
            batch.columns[0].iter_mut().for_each(|time| *time += start_s);
        }
        let columns: Vec<&[f64]> = batch.columns.iter().map(Vec::as_slice).collect();
        taking.push(&columns).map_err(refused)?;
    }
    taking.finish().map_err(refused)
}

/// The names of a table's columns, without decoding any.
fn columns(path: &Path) -> Result<Vec<String>, tables::Error> {
    if Format::of(path)? == Format::Parquet
        && let Ok(file) = File::open(path)
        && file.metadata().is_ok_and(|found| found.is_file())
    {
        let columns = tables::parquet_columns(file, &path.display().to_string())?;
        return Ok(columns.into_iter().map(|(name, _)| name).collect());
    }
    Ok(Reader::open(path, None)?.columns().to_vec())
}

fn document<S: Series>(series: &S, path: &Path, text: &str) -> Result<S::Partial, Fault> {
    let of_file = |error: String| Fault::Request(format!("{}: {error}", path.display()));
    if text.get(..64).unwrap_or(text).contains("fluxcal-partial") {
        let kind = S::Partial::KIND;
        return Err(of_file(format!(
            "found statistics that were written before; expected rows. To join statistics: {kind} merge"
        )));
    }
    let document = Document::parse(text).map_err(|error| of_file(error.to_string()))?;
    let mut pieces = Vec::new();
    for (index, one) in document.recordings.iter().enumerate() {
        if one.procedure == S::PROCEDURE
            && let Some(series) = series.of_recording(one, &format!("recordings[{index}]"))?
        {
            pieces.push(recording(&series, path, index, one)?);
        }
    }
    if pieces.is_empty() {
        let procedure = S::PROCEDURE;
        return Err(of_file(format!(
            "found no recording of the procedure {procedure}; expected at least one"
        )));
    }
    merge(pieces).map_err(|error| of_file(told::<S>(error)))
}

fn recording<S: Series>(
    series: &S,
    path: &Path,
    index: usize,
    recording: &Recording,
) -> Result<S::Partial, Fault> {
    let key = format!("recordings[{index}]");
    let start_s = recording.start().map_or(0.0, |start| start.unix_s);
    if let Some(beside) = &recording.table {
        let folder = path.parent().unwrap_or(Path::new(""));
        let beside = tables::beside(folder, beside).map_err(|error| {
            Fault::document(format!("{key}.table"), error.to_string(), "a file beside the document")
        })?;
        return table(series, &beside, start_s);
    }
    let there: Vec<String> = recording.columns.keys().cloned().collect();
    let (names, mut taking) = series
        .begin(&there)
        .map_err(|missing| Fault::document(format!("{key}.columns"), there.join(", "), missing))?;
    let mut columns: Vec<&[f64]> = names.iter().filter_map(|name| recording.column(name)).collect();
    let times: Vec<f64>;
    if let Some(first) = columns.first_mut().filter(|_| start_s != 0.0) {
        times = first.iter().map(|time| time + start_s).collect();
        *first = &times;
    }
    let taken = taking.push(&columns).and_then(|()| taking.finish());
    taken.map_err(|error| Fault::document(key, told::<S>(error), "rows of rising times"))
}

fn told<S: Series>(error: <S::Partial as Partial>::Error) -> String {
    let error: Fault = error.into();
    error.to_string()
}
