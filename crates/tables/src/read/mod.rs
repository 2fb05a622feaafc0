use std::collections::HashMap;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

use crate::{Batch, COLUMN_LIMIT, Error, Format, Place, error::listed};

mod ahead;
mod csv;
mod lines;
mod ndjson;
mod parquet;
mod text;

pub use parquet::{ColumnKind, columns as parquet_columns};

/// A table, read batch by batch: an iterator over its rows in the order of the file.
///
/// After an error it ends. Dropped early, it stops reading.
pub struct Reader {
    columns: Vec<String>,
    batches: Box<dyn Iterator<Item = Result<Batch, Error>> + Send>,
    failed: bool,
}

impl Reader {
    /// Opens a file whose extension states its format; see [`Format::of`]. Only the wanted columns are
    /// decoded and come in the order in which they are wanted; without a wish all come in the order of the
    /// file.
    ///
    /// It reads ahead with as many threads as rayon's current pool has, but not in that pool, so that a
    /// caller in the pool may wait for it.
    ///
    /// # Errors
    ///
    /// [`Error::File`] where it cannot be read, [`Error::Data`] where it does not begin as a table or lacks a
    /// wanted column, [`Error::Request`] where nothing is wanted, or something twice, or the format is not
    /// known. The rest of the file is judged when its batch is due.
    pub fn open(path: &Path, wanted: Option<&[&str]>) -> Result<Self, Error> {
        Self::open_as(path, Format::of(path)?, wanted)
    }

    /// As [`Reader::open`], with the format told.
    pub fn open_as(path: &Path, format: Format, wanted: Option<&[&str]>) -> Result<Self, Error> {
        let file = File::open(path).map_err(|source| Error::file(path, "read", source))?;
        let name = path.display().to_string();
        match format {
            // A pipe has no end to begin at.
            Format::Parquet if file.metadata().is_ok_and(|found| found.is_file()) => {
                parquet::open(file, name, wanted)
            }
            streamed => Self::from_read(file, streamed, &name, wanted),
        }
    }

    /// Reads Parquet from what can be read from any place, such as bytes in memory; `name` stands for it in
    /// errors.
    ///
    /// # Errors
    ///
    /// As [`Reader::open`].
    pub fn parquet(
        input: impl Read + Seek + Send + 'static,
        name: &str,
        wanted: Option<&[&str]>,
    ) -> Result<Self, Error> {
        parquet::open(input, name.into(), wanted)
    }

    /// Reads CSV or NDJSON from a stream; `name` stands for it in errors.
    ///
    /// # Errors
    ///
    /// As [`Reader::open`], and [`Error::Request`] for Parquet, which begins at its end.
    pub fn from_read(
        input: impl Read + Send + 'static,
        format: Format,
        name: &str,
        wanted: Option<&[&str]>,
    ) -> Result<Self, Error> {
        match format {
            Format::Csv => csv::open(input, name, wanted),
            Format::NdJson => ndjson::open(input, name, wanted),
            Format::Parquet => Err(no_stream(name)),
        }
    }

    /// Names of the columns that each batch has.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }
}

impl Iterator for Reader {
    type Item = Result<Batch, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.failed {
            return None;
        }
        let batch = self.batches.next();
        self.failed = matches!(batch, Some(Err(_)));
        batch
    }
}

fn no_stream(name: &str) -> Error {
    Error::Request(format!(
        "{name}: Parquet is read from its end and so cannot come from a stream; give a file, or pipe CSV or NDJSON"
    ))
}

/// Checks the names of a table, and gives the place of each wanted column among them.
fn select(source_name: &str, names: &[String], place: Place, wanted: &[&str]) -> Result<Vec<usize>, Error> {
    if names.len() > COLUMN_LIMIT {
        return Err(Error::data(
            source_name,
            place,
            format!("{} columns", names.len()),
            format!("at most {COLUMN_LIMIT}; are rows and columns exchanged?"),
        ));
    }
    let mut places = HashMap::new();
    for (column, name) in names.iter().enumerate() {
        if name.is_empty() {
            return Err(Error::data(
                source_name,
                place,
                format!("no name for column {}", column + 1),
                "a name for each (pandas: index=False)",
            ));
        }
        if let Some(first) = places.insert(name.as_str(), column) {
            let found = format!("column {name} twice, as columns {} and {}", first + 1, column + 1);
            return Err(Error::data(source_name, place, found, "a name of its own for each column"));
        }
    }
    let absent: Vec<_> = wanted.iter().copied().filter(|name| !places.contains_key(name)).collect();
    if !absent.is_empty() {
        return Err(Error::data(
            source_name,
            place,
            format!("no column {}", absent.join(", ")),
            format!("it among those there are: {}", listed(names)),
        ));
    }
    Ok(wanted.iter().map(|name| places[name]).collect())
}

/// Refuses an empty wish and a name in it twice.
fn check_wish(source_name: &str, wanted: Option<&[&str]>) -> Result<(), Error> {
    let Some(wanted) = wanted else { return Ok(()) };
    let twice = wanted.iter().enumerate().find(|(column, name)| wanted[..*column].contains(name));
    match (wanted.is_empty(), twice) {
        (true, _) => Err(Error::Request(format!("{source_name}: no columns are wanted; name one at least"))),
        (_, Some((_, name))) => Err(Error::Request(format!("{source_name}: column {name} is wanted twice"))),
        _ => Ok(()),
    }
}
