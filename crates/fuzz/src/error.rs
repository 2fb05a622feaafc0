use std::path::PathBuf;
use thiserror::Error;

/// Why no case was run.
#[derive(Debug, Error)]
pub enum Error {
    /// The request is wrong, or a file cannot be read or written.
    #[error(transparent)]
    Common(#[from] common::Error),
    /// There were findings.
    #[error("{0}")]
    Found(String),
}

impl Error {
    /// A file that cannot be `read`, `written` or `run`.
    pub fn file(path: impl Into<PathBuf>, action: &'static str, source: std::io::Error) -> Self {
        Error::Common(common::Error::File { path: path.into(), action, source })
    }

    /// A request that cannot be answered.
    pub fn request(message: impl Into<String>) -> Self {
        Error::Common(common::Error::Request(message.into()))
    }
}

impl From<Error> for common::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Common(error) => error,
            Error::Found(message) => common::Error::Unanswerable(message),
        }
    }
}
