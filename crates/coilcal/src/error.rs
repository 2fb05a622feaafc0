use thiserror::Error;

/// Why there is no answer.
#[derive(Debug, Error)]
pub enum Error {
    /// The document is wrong.
    #[error(transparent)]
    Document(#[from] common::Error),
    /// No recording is for this stage.
    #[error(
        "no recording with the procedure `coil_constant`, `coil_gradient` or `nulling_residual`; coilcal needs currents (or voltages across a resistor) with `reference_nt`, or readings in the nulled field"
    )]
    Nothing,
    /// The readings do not determine the answer.
    #[error("{0}")]
    Undetermined(String),
    /// The estimation failed.
    #[error("the coil constant could not be fitted: {0}")]
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
