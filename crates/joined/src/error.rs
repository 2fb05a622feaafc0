use thiserror::Error;

/// Why recordings cannot be joined.
#[derive(Debug, Error)]
pub enum Error {
    /// The document is wrong.
    #[error(transparent)]
    Document(#[from] common::Error),
    /// No recording is for this.
    #[error(
        "no recording with the procedure `differential`; diffmag needs `reference_x_nt`, … and `test_x_nt`, … of two magnetometers side by side"
    )]
    Nothing,
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
            Error::Nothing => common::Error::Request(error.to_string()),
            Error::Undetermined(_) | Error::Estimate(_) => common::Error::Unanswerable(error.to_string()),
        }
    }
}
