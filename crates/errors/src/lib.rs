//! The error with which every program refuses, and how errors of libraries become one.

use std::path::PathBuf;
use thiserror::Error;

/// What a program's exit code says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExitCode {
    /// The data do not allow the answer.
    Unanswerable = 1,
    /// The request or the document is wrong.
    Refused = 2,
}

/// An error as a person reads it: what was found, where, what was expected, what to do.
#[derive(Debug, Error)]
pub enum Error {
    /// Something in the document is not as it must be.
    #[error("{path}: found {found}; expected {expected}")]
    Document {
        /// JSON path, `recordings[2].conditions.orientation`.
        path: String,
        /// What stands there.
        found: String,
        /// What should, and what to do.
        expected: String,
    },
    /// The text is not one JSON document.
    #[error("{message}")]
    Syntax {
        /// What is wrong and what to do.
        message: String,
    },
    /// An error with the place in its source.
    #[error("{source_name}, line {line}: {error}")]
    At {
        /// The file's name, or `standard input`.
        source_name: String,
        /// Line, from 1.
        line: usize,
        /// The error itself.
        error: Box<Error>,
    },
    /// What was asked cannot be done.
    #[error("{0}")]
    Request(String),
    /// The data do not allow the answer: which rank, which rows, what measurement would help.
    #[error("{0}")]
    Unanswerable(String),
    /// An estimation failed: why.
    #[error("the fit failed: {0}")]
    Fit(String),
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

impl Error {
    /// An error at a JSON path.
    pub fn document(path: impl Into<String>, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Error::Document { path: path.into(), found: found.into(), expected: expected.into() }
    }

    /// A file or stream that cannot be `read`, `written` or `run`.
    pub fn file(path: impl Into<PathBuf>, action: &'static str, source: std::io::Error) -> Self {
        Error::File { path: path.into(), action, source }
    }

    /// The error with its JSON path below another one.
    pub fn below(self, parent: &str) -> Self {
        match self {
            Error::Document { path, found, expected } => {
                let path = match path.as_str() {
                    "the document" => parent.into(),
                    index if index.starts_with('[') => format!("{parent}{index}"),
                    name => format!("{parent}.{name}"),
                };
                Error::Document { path, found, expected }
            }
            error => error,
        }
    }

    /// Of a document that was to be written: the readings gave such a number.
    pub fn came_out(self) -> Self {
        match self {
            Error::Document { path, found, .. } => Error::Unanswerable(format!(
                "{path} came out as {found}, which no instrument has: the recordings do not determine it. Nothing was written"
            )),
            error => error,
        }
    }

    /// The error with other words for a fit that failed, given why.
    pub fn of_fit(self, words: impl FnOnce(&str) -> String) -> Self {
        match self {
            Error::Fit(why) => Error::Unanswerable(words(&why)),
            error => error,
        }
    }

    /// The code with which a program ends on this error.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Error::Unanswerable(_) | Error::Fit(_) => ExitCode::Unanswerable,
            Error::At { error, .. } => error.exit_code(),
            _ => ExitCode::Refused,
        }
    }

    /// The JSON path that the error is about, where it is about one.
    pub fn path(&self) -> Option<&str> {
        match self {
            Error::Document { path, .. } => Some(path),
            _ => None,
        }
    }
}

/// An error of a library, as a program tells it: in its own words, as those of a request that cannot be met,
/// unless the library says otherwise.
pub trait Told: std::error::Error + Sized {
    /// The program's error.
    fn told(self) -> Error {
        Error::Request(self.to_string())
    }
}

impl<E: Told> From<E> for Error {
    fn from(error: E) -> Self {
        error.told()
    }
}
