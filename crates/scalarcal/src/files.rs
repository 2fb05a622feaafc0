//! Pieces of long series from files: tables, documents, and statistics that were written before.

use common::{Axis, Document, Error as Fault, Recording, procedure, range};
use physics::Unit;
use std::fs;
use std::path::Path;
use tables::Reader;

use crate::Error;
use crate::read::Source;
use crate::stream::{self, Batch, Partial, Statistics};

/// Takes a file in one pass and bounded memory: CSV, NDJSON or Parquet by its extension, `.json` a document or a piece that was
/// written before.
///
/// # Errors
///
/// A file that cannot be read, or rows whose times do not rise, each with file and row.
pub fn take(path: &Path) -> Result<Partial, Error> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
        return take_json(path);
    }
    take_table(path, 0.0)
}

/// Columns that are used, of those that there are.
struct Wanted {
    names: Vec<String>,
    unit: Unit,
    source: Source,
}

impl Wanted {
    /// Of the names of columns; what is missing where there are not enough.
    fn among(there: &[String]) -> Result<Self, String> {
        let has = |name: &String| there.contains(name);
        let sensors = |unit: &Unit| Axis::ALL.map(|axis| format!("sensor_{axis}_{}", unit.suffix()));
        let unit = [Unit::Volt, Unit::Nanotesla].into_iter().find(|unit| sensors(unit).iter().all(has));
        let unit = unit.ok_or("`sensor_x_v`, `sensor_y_v`, `sensor_z_v` (or `_nt`)")?;
        let ambient = Axis::ALL.map(|axis| format!("ambient_{axis}_nt"));
        let reference = "reference_nt".to_string();
        let (source, magnitude) = if has(&reference) {
            (Source::Scalar, vec![reference])
        } else if ambient.iter().all(has) {
            (Source::Ambient, ambient.to_vec())
        } else {
            return Err("`reference_nt`, or `ambient_x_nt`, `ambient_y_nt`, `ambient_z_nt`".into());
        };
        let time = "time_s".to_string();
        if !has(&time) {
            return Err("`time_s`".into());
        }
        let names = std::iter::once(time).chain(sensors(&unit)).chain(magnitude).collect();
        Ok(Self { names, unit, source })
    }

    /// Gives rows, in the order of the names, to statistics.
    fn push(
        &self,
        statistics: &mut Statistics,
        columns: &[&[f64]],
        start_s: f64,
    ) -> Result<(), stream::Error> {
        let [time, x, y, z, magnitude @ ..] = columns else { return Err(stream::Error::Empty) };
        let later: Vec<f64>;
        let time_s = if start_s == 0.0 {
            *time
        } else {
            later = time.iter().map(|time| time + start_s).collect();
            &later
        };
        let length: Vec<f64>;
        let magnitude_nt = match magnitude {
            [bx, by, bz] => {
                length = (0..bx.len()).map(|row| bx[row].hypot(by[row]).hypot(bz[row])).collect();
                &length
            }
            _ => magnitude[0],
        };
        statistics.push(&Batch { time_s, readings: [x, y, z], magnitude_nt })
    }
}

fn take_table(path: &Path, start_s: f64) -> Result<Partial, Error> {
    let refused = |reason: String| Error::Document(Fault::Request(reason));
    let of_file = |reason: String| refused(format!("{}: {reason}", path.display()));
    let unreadable = |error: tables::Error| refused(error.to_string());
    let there = Reader::open(path, None).map_err(unreadable)?.columns().to_vec();
    let wanted = Wanted::among(&there).map_err(|missing| {
        of_file(format!("found the columns {}; expected {missing} among them", there.join(", ")))
    })?;
    let names: Vec<&str> = wanted.names.iter().map(String::as_str).collect();
    let mut statistics = Statistics::new(wanted.unit, wanted.source);
    for batch in Reader::open(path, Some(&names)).map_err(unreadable)? {
        let batch = batch.map_err(unreadable)?;
        let columns: Vec<&[f64]> = batch.columns.iter().map(Vec::as_slice).collect();
        let named = names.iter().copied().zip(columns.iter().copied());
        range::rows(&path.display().to_string(), batch.first_row, named)?;
        wanted.push(&mut statistics, &columns, start_s).map_err(|error| of_file(error.to_string()))?;
    }
    statistics.finish().map_err(|error| of_file(error.to_string()))
}

fn take_json(path: &Path) -> Result<Partial, Error> {
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
        .filter(|(_, recording)| recording.procedure == procedure::FREE_RUN)
        .map(|(index, recording)| take_recording(path, index, recording))
        .collect::<Result<_, _>>()?;
    stream::merge(pieces).map_err(refused)
}

/// A recording of a document, its times since 1970 where it says when it began.
fn take_recording(path: &Path, index: usize, recording: &Recording) -> Result<Partial, Error> {
    let key = format!("recordings[{index}]");
    let start_s = recording.start().map_or(0.0, |start| start.unix_s);
    if let Some(table) = &recording.table {
        let folder = path.parent().unwrap_or(Path::new(""));
        let beside = tables::beside(folder, table).map_err(|error| {
            Fault::document(format!("{key}.table"), error.to_string(), "a file beside the document")
        })?;
        return take_table(&beside, start_s);
    }
    let there: Vec<String> = recording.columns.keys().cloned().collect();
    let wanted = Wanted::among(&there)
        .map_err(|missing| Fault::document(format!("{key}.columns"), there.join(", "), missing))?;
    let columns: Vec<&[f64]> = wanted.names.iter().filter_map(|name| recording.column(name)).collect();
    let mut statistics = Statistics::new(wanted.unit, wanted.source);
    wanted
        .push(&mut statistics, &columns, start_s)
        .and_then(|()| statistics.finish())
        .map_err(|error| Fault::document(key, error.to_string(), "rows with rising times").into())
}
