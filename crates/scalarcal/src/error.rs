use thiserror::Error;

/// Why there is no answer.
#[derive(Debug, Error)]
pub enum Error {
    /// The document or the request is wrong.
    #[error(transparent)]
    Document(#[from] common::Error),
    /// Instruments in recordings of their own cannot be joined.
    #[error(transparent)]
    Joined(#[from] joined::Error),
    /// A recording cannot be read by the forward model.
    #[error("{path}: {source}")]
    Physics {
        /// JSON path.
        path: String,
        /// The model's word.
        source: physics::Error,
    },
    /// The recordings do not determine the calibration.
    #[error("{0}")]
    Undetermined(String),
    /// The estimation failed.
    #[error(
        "the calibration failed: {0}. Check for outliers (--robust), and for a reference in another unit"
    )]
    Estimate(#[from] estimate::Error),
}

impl From<Error> for common::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Document(error) => error,
            Error::Joined(error) => error.into(),
            Error::Physics { path, source } => source.at(&path),
            Error::Undetermined(message) => common::Error::Unanswerable(message),
            Error::Estimate(_) => common::Error::Unanswerable(error.to_string()),
        }
    }
}
