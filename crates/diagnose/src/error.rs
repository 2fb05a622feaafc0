use thiserror::Error;

/// Why there is no answer.
#[derive(Debug, Error)]
pub enum Error {
    /// The document is wrong.
    #[error(transparent)]
    Document(#[from] common::Error),
    /// No recording can be predicted.
    #[error(
        "no recording whose readings can be predicted: {0}; diagnose needs readings of sensors (`sensor_x_v`, `sensor_x_nt`, …), of a scalar magnetometer in a coil, or of two magnetometers side by side"
    )]
    Nothing(String),
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
            Error::Nothing(_) => common::Error::Request(error.to_string()),
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
