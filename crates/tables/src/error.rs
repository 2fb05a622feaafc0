pub use errors::Error;
use std::fmt;

/// Characters of a file that an error repeats.
const QUOTED: usize = 40;

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

/// The error of what stands at a place of a file, or of `standard input`, and should be something else.
pub fn fault(
    source_name: &str,
    place: Place,
    found: impl fmt::Display,
    expected: impl fmt::Display,
) -> Error {
    Error::Request(format!("{source_name}{place}: found {found}; expected {expected}"))
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

/// Names, as an error lists them: so many at most.
pub fn listed(names: &[String], most: usize) -> String {
    let text = names[..names.len().min(most)].join(", ");
    if names.len() > most { format!("{text}, and {} more", names.len() - most) } else { text }
}
