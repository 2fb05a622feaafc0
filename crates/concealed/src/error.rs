use std::path::PathBuf;
use thiserror::Error;

/// Why there is no score.
#[derive(Debug, Error)]
pub enum Error {
    /// The request is wrong, or a file cannot be read or written.
    #[error(transparent)]
    Common(#[from] common::Error),
    /// A program ended with an error.
    #[error("{program} on {document}: {words}; run it by itself to see more")]
    Program {
        /// Which.
        program: PathBuf,
        /// What it was given.
        document: PathBuf,
        /// Its last words.
        words: String,
    },
    /// A sealed truth was changed after it was sealed.
    #[error("{path}: found SHA-256 {found}; expected {sealed}, as seals.txt has it. Make the set again")]
    Seal {
        /// The truth.
        path: PathBuf,
        /// Its digest.
        found: String,
        /// The digest that was stored before.
        sealed: String,
    },
}

impl Error {
    /// A file that cannot be `read` or `written`.
    pub fn file(path: impl Into<PathBuf>, action: &'static str, source: std::io::Error) -> Self {
        Error::Common(common::Error::File { path: path.into(), action, source })
    }
}

impl From<Error> for common::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Common(error) => error,
            other => common::Error::Request(other.to_string()),
        }
    }
}
