use thiserror::Error;

/// Why there is no answer.
#[derive(Debug, Error)]
pub enum Error {
    /// The document is wrong.
    #[error(transparent)]
    Document(#[from] common::Error),
    /// No recording is for this stage.
    #[error(
        "no recording with the procedure `sensor_sensitivity`, `sensor_offset_reversal`, `sensor_noise`, `offset_drift`, `temperature_run` or `cross_field`; sensorcal needs readings of a sensor in a coil's field or in a shield"
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
            Error::Undetermined(message) => common::Error::Unanswerable(message),
            Error::Estimate(_) => common::Error::Unanswerable(error.to_string()),
        }
    }
}
