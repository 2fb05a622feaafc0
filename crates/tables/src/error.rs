use errors::Told;
use std::fmt;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Characters of a file that an error repeats.
const QUOTED: usize = 40;

/// An error as a person reads it: where, what was found, what was expected.
#[derive(Debug, Error)]
pub enum Error {
    /// A table is not as it must be.
    #[error("{source_name}{place}: found {found}; expected {expected}")]
    Data {
        /// The file's name, or `standard input`.
        source_name: String,
        /// Where in it.
        place: Place,
        /// What stands there.
        found: String,
        /// What should, and what to do.
        expected: String,
    },
    /// What was asked cannot be done.
    #[error("{0}")]
    Request(String),
    /// A file or stream failed.
    #[error("{path}: cannot be {action}: {source}")]
    File {
        /// Which.
        path: PathBuf,
        /// `read` or `written`.
        action: &'static str,
        /// The system's word.
        source: std::io::Error,
    },
}

impl Told for Error {
    fn told(self) -> errors::Error {
        match self {
            Error::File { path, action, source } => errors::Error::File { path, action, source },
            other => errors::Error::Request(other.to_string()),
        }
    }
}

/// A place in a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    Whole,
    /// A line of text, from 1.
    Line(u64),
    /// A value of a CSV file.
    Field {
        /// Line, from 1.
        line: u64,
        /// Column, from 1.
        column: usize,
        /// The column's name.
        name: String,
    },
    /// A value of an NDJSON file.
    Key {
        /// Line, from 1.
        line: u64,
        /// Its key.
        key: String,
    },
    /// A value of a table without lines.
    Row {
        /// Row, from 1.
        row: u64,
        /// The column's name.
        name: String,
    },
    /// A column.
    Column(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Place::Whole => Ok(()),
            Place::Line(line) => write!(f, ", line {line}"),
            Place::Field { line, column, name } => write!(f, ", line {line}, column {column} ({name})"),
            Place::Key { line, key } => write!(f, ", line {line}, key {key}"),
            Place::Row { row, name } => write!(f, ", row {row}, column {name}"),
            Place::Column(name) => write!(f, ", column {name}"),
        }
    }
}

impl Error {
    pub(crate) fn data(
        source_name: &str,
        place: Place,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Error::Data { source_name: source_name.into(), place, found: found.into(), expected: expected.into() }
    }

    pub(crate) fn file(path: impl AsRef<Path>, action: &'static str, source: std::io::Error) -> Self {
        Error::File { path: path.as_ref().into(), action, source }
    }
}

/// Text of a file, as an error repeats it.
pub(crate) fn quoted(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(4 * QUOTED)]);
    let mut short: String = text.chars().take(QUOTED).collect();
    if short.len() < bytes.len() {
        short.push('…');
    }
    format!("{short:?}")
}

/// Names, as an error lists them.
pub(crate) fn listed(names: &[String]) -> String {
    const SHOWN: usize = 30;
    let mut text = names[..names.len().min(SHOWN)].join(", ");
    if names.len() > SHOWN {
        text.push_str(&format!(", and {} more", names.len() - SHOWN));
    }
    text
}
