use thiserror::Error;

/// Why a plan cannot be carried out.
#[derive(Debug, Error)]
pub enum Error {
    /// The plan itself is wrong.
    #[error(transparent)]
    Plan(#[from] common::Error),
    /// The forward model refuses a recording of the plan.
    #[error("{path}: {source}")]
    Physics {
        /// JSON path in the plan.
        path: String,
        /// The model's word.
        source: physics::Error,
    },
}

impl From<Error> for common::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Plan(error) => error,
            Error::Physics { path, source } => source.at(&path),
        }
    }
}
