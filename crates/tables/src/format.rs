use std::path::Path;

use crate::Error;

/// How a table is written down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A line of names, then a line a row, cut at commas.
    Csv,
    /// A JSON object a line.
    NdJson,
    /// Apache Parquet.
    Parquet,
}

impl Format {
    /// The format that a file's extension states: `.csv`, `.ndjson` or `.jsonl`, `.parquet`, in capitals too.
    ///
    /// # Errors
    ///
    /// [`Error::Request`] for any other.
    pub fn of(path: &Path) -> Result<Self, Error> {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        match extension.to_str() {
            Some("csv") => Ok(Format::Csv),
            Some("ndjson" | "jsonl") => Ok(Format::NdJson),
            Some("parquet") => Ok(Format::Parquet),
            _ => Err(Error::Request(format!(
                "{}: the file's name does not say its format; expected .csv, .ndjson, .jsonl or .parquet",
                path.display()
            ))),
        }
    }
}
