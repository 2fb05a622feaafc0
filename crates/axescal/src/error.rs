use thiserror::Error;

/// Why there is no answer.
#[derive(Debug, Error)]
pub enum Error {
    /// The document or the request is wrong.
    #[error(transparent)]
    Document(#[from] common::Error),
    /// A recording cannot be read by the forward model.
    #[error("{path}: {source}")]
    Physics {
        /// JSON path.
        path: String,
        /// The model's word.
        source: physics::Error,
    },
    /// The recordings do not determine the directions.
    #[error("{0}")]
    RankShort(String),
    /// The estimation failed.
    #[error(
        "the fit of the directions failed: {0}. Readings may be paired with the wrong orientations, or the start may be far off: try --robust, or --start=document with a first model"
    )]
    Estimate(#[from] estimate::Error),
}

impl From<Error> for common::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Document(error) => error,
            Error::Physics { path, source } => source.at(&path),
            Error::RankShort(message) => common::Error::Unanswerable(message),
            Error::Estimate(_) => common::Error::Unanswerable(error.to_string()),
        }
    }
}
