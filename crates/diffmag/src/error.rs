use thiserror::Error;

/// Why there is no answer.
#[derive(Debug, Error)]
pub enum Error {
    /// The document is wrong.
    #[error(transparent)]
    Document(#[from] common::Error),
    /// No recording is for this stage.
    #[error(
        "no recording with the procedure `differential`; diffmag needs `reference_x_nt`, … and `test_x_nt`, … of two magnetometers side by side"
    )]
    Nothing,
    /// The readings do not determine the answer.
    #[error("{0}")]
    Undetermined(String),
    /// The estimation failed.
    #[error("no fit was found: {0}")]
    Estimate(#[from] estimate::Error),
}

impl From<Error> for common::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Document(error) => error,
            Error::Nothing => common::Error::Request(error.to_string()),
            Error::Undetermined(message) => common::Error::Unanswerable(message),
            Error::Estimate(_) => common::Error::Unanswerable(error.to_string()),
        }
    }
}

impl From<joined::Error> for Error {
    fn from(error: joined::Error) -> Self {
        match error {
            joined::Error::Document(error) => Self::Document(error),
            joined::Error::Nothing => Self::Nothing,
            joined::Error::Undetermined(message) => Self::Undetermined(message),
            joined::Error::Estimate(error) => Self::Estimate(error),
        }
    }
}
