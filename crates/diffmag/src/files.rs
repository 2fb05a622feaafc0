//! Pieces of long series from files: tables, documents, and statistics that were written before.

use common::{Axis, Document, Error as Fault, Recording, procedure, range};
use std::fs;
use std::path::Path;
use tables::Reader;

use crate::Error;
use crate::stream::{self, Batch, Grid, Partial, Statistics};

/// Columns of a table of two magnetometers side by side.
pub const COLUMNS: [&str; 7] =
    ["time_s", "reference_x_nt", "reference_y_nt", "reference_z_nt", "test_x_nt", "test_y_nt", "test_z_nt"];

/// Takes a file in one pass and bounded memory: CSV, NDJSON or Parquet by its extension, `.json` a document or a piece that was
/// written before. `step_s` is from one sample to the next, found from the first rows where it is not told.
///
/// # Errors
///
/// A file that cannot be read, or rows that do not stand on a grid of rising times, each with file and row.
pub fn take(path: &Path, step_s: Option<f64>) -> Result<Partial, Error> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
        return take_json(path, step_s);
    }
    let refused = |reason: String| Error::Document(Fault::Request(reason));
    let reader = Reader::open(path, Some(&COLUMNS)).map_err(|error| refused(error.to_string()))?;
    let mut statistics: Option<Statistics> = None;
    for batch in reader {
        let batch = batch.map_err(|error| refused(error.to_string()))?;
        let columns = COLUMNS.into_iter().zip(batch.columns.iter().map(Vec::as_slice));
        range::rows(&path.display().to_string(), batch.first_row, columns)?;
        let [time_s, rx, ry, rz, tx, ty, tz] = std::array::from_fn(|k| batch.columns[k].as_slice());
        let rows = Batch { time_s, reference_nt: [rx, ry, rz], test_nt: [tx, ty, tz] };
        push(&mut statistics, &rows, step_s)
            .map_err(|error| refused(format!("{}: {error}", path.display())))?;
    }
    let taken = statistics.unwrap_or_default().finish();
    taken.map_err(|error| refused(format!("{}: {error}", path.display())))
}

/// The next rows; the first ones start the statistics.
fn push(
    statistics: &mut Option<Statistics>,
    rows: &Batch<'_>,
    step_s: Option<f64>,
) -> Result<(), stream::Error> {
    if statistics.is_none() {
        *statistics = Some(match (step_s, rows.time_s.first()) {
            (Some(step_s), Some(first)) => Statistics::on(Grid::of(step_s, *first)?),
            _ => Statistics::new(),
        });
    }
    statistics.get_or_insert_default().push(rows)
}

fn take_json(path: &Path, step_s: Option<f64>) -> Result<Partial, Error> {
    let text = fs::read_to_string(path).map_err(|source| Fault::File {
        path: path.into(),
        action: "read",
        source,
    })?;
    let of_file = |error: String| Error::Document(Fault::Request(format!("{}: {error}", path.display())));
    let refused = |error: stream::Error| of_file(error.to_string());
    if text.get(..64).unwrap_or(&text).contains("fluxcal-partial") {
        return Partial::parse(&text).map_err(refused);
    }
    let document = Document::parse(&text).map_err(|error| of_file(error.to_string()))?;
    let pieces: Vec<Partial> = document
        .recordings
        .iter()
        .enumerate()
        .filter(|(_, recording)| recording.procedure == procedure::DIFFERENTIAL)
        .map(|(index, recording)| take_recording(path, index, recording, step_s))
        .collect::<Result<_, _>>()?;
    stream::merge(pieces).map_err(refused)
}

/// A recording of a document, its times since 1970 where it says when it began.
fn take_recording(
    path: &Path,
    index: usize,
    recording: &Recording,
    step_s: Option<f64>,
) -> Result<Partial, Error> {
    let key = format!("recordings[{index}]");
    if let Some(table) = &recording.table {
        let folder = path.parent().unwrap_or(Path::new(""));
        let beside = tables::beside(folder, table).map_err(|error| {
            Fault::document(format!("{key}.table"), error.to_string(), "a file beside the document")
        })?;
        return take(&beside, step_s);
    }
    let start = recording.start().map_or(0.0, |start| start.unix_s);
    let column = |name: &str| {
        recording.column(name).ok_or_else(|| {
            let expected = format!("`{name}`, one column for each axis of both instruments");
            Fault::document(format!("{key}.columns"), "no such column", expected)
        })
    };
    let times: Vec<f64> = column("time_s")?.iter().map(|time| time + start).collect();
    let axes = |quantity: &str| -> Result<[&[f64]; 3], Fault> {
        let [x, y, z] = Axis::ALL.map(|axis| column(&format!("{quantity}_{axis}_nt")));
        Ok([x?, y?, z?])
    };
    let rows = Batch { time_s: &times, reference_nt: axes("reference")?, test_nt: axes("test")? };
    let mut statistics = None;
    push(&mut statistics, &rows, step_s).and_then(|()| statistics.unwrap_or_default().finish()).map_err(
        |error| Fault::document(key, error.to_string(), "rows on an even grid of rising times").into(),
    )
}
