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
    #[error(transparent)]
    Estimate(#[from] estimate::Error),
}
