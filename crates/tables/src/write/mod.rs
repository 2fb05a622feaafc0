use crate::files::{self, Unfinished};
use std::collections::HashSet;
use std::io::Write;
use std::path::Path;

use crate::{COLUMN_LIMIT, Error, Format};

mod parquet;
mod text;

/// A table, written batch by batch.
///
/// A file gets its name when [`Writer::finish`] is called: so it is there whole or not at all. What is no
/// file (a terminal, a named pipe) is written to as it is.
pub struct Writer {
    /// As it is named in errors.
    name: String,
    columns: usize,
    rows: u64,
    output: Output,
    file: Option<Unfinished>,
}

enum Output {
    Text(text::Text),
    Parquet(parquet::Groups),
}

impl Writer {
    /// Begins a file whose extension states its format; see [`Format::of`].
    ///
    /// # Errors
    ///
    /// [`Error::File`] where it cannot be written, [`Error::Request`] for no columns, too many, a name that
    /// is empty or there twice, is a number, begins with `#`, or has blanks at its ends or a line's end
    /// within, and a format that is not known.
    pub fn create(path: &Path, columns: &[&str]) -> Result<Self, Error> {
        Self::create_as(path, Format::of(path)?, columns)
    }

    /// As [`Writer::create`], with the format told.
    pub fn create_as(path: &Path, format: Format, columns: &[&str]) -> Result<Self, Error> {
        let name = path.display().to_string();
        check_names(&name, columns)?;
        let (file, unfinished) =
            files::create(path).map_err(|source| Error::file(path, "written", source))?;
        Ok(Writer { file: Some(unfinished), ..Self::begin(file, format, name, columns)? })
    }

    /// Writes to a stream, in any format; `name` stands for it in errors.
    ///
    /// # Errors
    ///
    /// As [`Writer::create`].
    pub fn to_write(
        output: impl Write + Send + 'static,
        format: Format,
        name: &str,
        columns: &[&str],
    ) -> Result<Self, Error> {
        check_names(name, columns)?;
        Self::begin(output, format, name.into(), columns)
    }

    fn begin(
        output: impl Write + Send + 'static,
        format: Format,
        name: String,
        columns: &[&str],
    ) -> Result<Self, Error> {
        let failed = |source| Error::file(&name, "written", source);
        let output = match format {
            Format::Csv => Output::Text(text::Text::csv(output, columns).map_err(failed)?),
            Format::NdJson => Output::Text(text::Text::ndjson(output, columns)),
            Format::Parquet => Output::Parquet(parquet::Groups::new(output, columns).map_err(failed)?),
        };
        Ok(Writer { name, columns: columns.len(), rows: 0, output, file: None })
    }

    /// Appends rows, given column by column; NaN is written as missing. Numbers are written with the fewest
    /// digits from which they are read back bit by bit.
    ///
    /// # Errors
    ///
    /// [`Error::Request`] for another number of columns than begun with, columns of unequal length and
    /// infinite numbers; [`Error::File`] where it cannot be written.
    pub fn write(&mut self, columns: &[impl AsRef<[f64]> + Sync]) -> Result<(), Error> {
        let columns: Vec<&[f64]> = columns.iter().map(AsRef::as_ref).collect();
        let rows = columns.first().map_or(0, |column| column.len());
        if columns.len() != self.columns || columns.iter().any(|column| column.len() != rows) {
            let lengths: Vec<_> = columns.iter().map(|column| column.len()).collect();
            return Err(Error::Request(format!(
                "{}: columns of {lengths:?} rows cannot be written; expected {} columns of the same length",
                self.name, self.columns
            )));
        }
        for (place, column) in columns.iter().enumerate() {
            if let Some(row) = column.iter().position(|value| value.is_infinite()) {
                return Err(Error::Request(format!(
                    "{}: row {} of column {} is infinite and is not written; expected finite numbers, NaN where one is missing",
                    self.name,
                    self.rows + row as u64 + 1,
                    place + 1
                )));
            }
        }
        self.rows += rows as u64;
        let written = match &mut self.output {
            Output::Text(text) => text.write(&columns),
            Output::Parquet(groups) => groups.write(&columns),
        };
        written.map_err(|source| Error::file(&self.name, "written", source))
    }

    /// Writes what is left, and gives a file its name.
    ///
    /// # Errors
    ///
    /// [`Error::File`] where that fails; there is then no file.
    pub fn finish(self) -> Result<(), Error> {
        let Writer { name, output, file, .. } = self;
        let finished = match output {
            Output::Text(text) => text.finish(),
            Output::Parquet(groups) => groups.finish(),
        };
        let named = finished.and_then(|()| file.map_or(Ok(()), Unfinished::finish));
        named.map_err(|source| Error::file(name, "written", source))
    }
}

fn check_names(name: &str, columns: &[&str]) -> Result<(), Error> {
    let mut met = HashSet::new();
    let fault = if columns.is_empty() {
        Some("without columns".to_string())
    } else if columns.len() > COLUMN_LIMIT {
        Some(format!("of {} columns, more than {COLUMN_LIMIT},", columns.len()))
    } else {
        columns.iter().find_map(|column| {
            let unreadable = column.is_empty()
                || column.trim() != *column
                || column.contains(['\n', '\r'])
                || column.starts_with('#')
                || column.parse::<f64>().is_ok();
            match (unreadable, met.insert(*column)) {
                (true, _) => Some(format!("with the column name {column:?}")),
                (false, false) => Some(format!("with two columns {column}")),
                (false, true) => None,
            }
        })
    };
    match fault {
        None => Ok(()),
        Some(fault) => Err(Error::Request(format!(
            "{name}: a table {fault} is not written; expected columns with names of their own"
        ))),
    }
}
