use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

use crate::{Error, Format};

mod ahead;
mod csv;
mod lines;
mod ndjson;
mod parquet;
mod reader;
mod text;
mod wanted;

pub use parquet::{ColumnKind, columns as parquet_columns};
pub use reader::{BATCH_ROWS, Batch, Reader};

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
    /// [`Error::File`] where it cannot be read, [`Error::Request`] where it does not begin as a table or
    /// lacks a wanted column, where nothing is wanted, or something twice, or the format is not known. The
    /// rest of the file is judged when its batch is due.
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
}

fn no_stream(name: &str) -> Error {
    Error::Request(format!(
        "{name}: Parquet is read from its end and so cannot come from a stream; give a file, or pipe CSV or NDJSON"
    ))
}
