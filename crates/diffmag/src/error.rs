use thiserror::Error;

/// Why there is no answer.
#[derive(Debug, Error)]
pub enum Error {
    /// The document is wrong.
    #[error(transparent)]
    Document(#[from] common::Error),
    /// The readings do not determine the answer.
    #[error("{0}")]
    Undetermined(String),
    /// The estimation failed.
    #[error("the fit failed: {0}")]
    Estimate(#[from] estimate::Error),
}

impl From<Error> for common::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Document(error) => error,
            Error::Undetermined(message) => common::Error::Unanswerable(message),
            Error::Estimate(_) => common::Error::Unanswerable(error.to_string()),
        }
    }
}

impl From<joined::Error> for Error {
    fn from(error: joined::Error) -> Self {
        Self::Document(error.into())
    }
}
