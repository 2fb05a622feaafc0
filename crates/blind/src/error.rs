use std::path::PathBuf;
use testkit::programs;
use thiserror::Error;

/// Why there is no score.
#[derive(Debug, Error)]
pub enum Error {
    /// The request is wrong, or a file cannot be read or written.
    #[error(transparent)]
    Common(#[from] common::Error),
    /// A program gave no answer.
    #[error(transparent)]
    Program(#[from] programs::Error),
    /// A truth is not the one that was sealed.
    #[error(
        "{path}: the truth of {case} has SHA-256 {found}; expected {sealed}, as seals.txt has it. Make the set again"
    )]
    Seal {
        /// The file of the truths.
        path: PathBuf,
        /// The case.
        case: String,
        /// Its digest.
        found: String,
        /// The digest that was stored before.
        sealed: String,
    },
    /// Answers that were not there, or not the same, when the truths were opened.
    #[error(
        "{answers}: these answers were not there when the truths were opened ({opened}); make a fresh set for them with blind make"
    )]
    Late {
        /// The folder of the answers.
        answers: PathBuf,
        /// The file that says which answers there were.
        opened: PathBuf,
    },
}

impl Error {
    /// A file that cannot be `read` or `written`.
    pub fn file(path: impl Into<PathBuf>, action: &'static str, source: std::io::Error) -> Self {
        Error::Common(common::Error::File { path: path.into(), action, source })
    }

    /// A file that is not the JSON it should be.
    pub fn unreadable(path: impl Into<PathBuf>, source: serde_json::Error) -> Self {
        Self::file(path, "read", std::io::Error::other(source))
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
