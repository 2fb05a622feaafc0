use thiserror::Error;

/// Why there is no corrected field.
#[derive(Debug, Error)]
pub enum Error {
    /// The document is wrong.
    #[error(transparent)]
    Document(#[from] common::Error),
    /// No recording can be corrected.
    #[error(
        "no recording holds readings of three sensors; correct needs `sensor_x_v`, `sensor_y_v` and `sensor_z_v`, or the same in nT"
    )]
    Nothing,
    /// A table is wrong.
    #[error("{0}")]
    Table(#[from] tables::Error),
    /// The chain has no inverse anywhere.
    #[error("{0}")]
    Hidden(String),
}

impl From<Error> for common::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Document(error) => error,
            Error::Nothing | Error::Table(_) => common::Error::Request(error.to_string()),
            Error::Hidden(message) => common::Error::Unanswerable(message),
        }
    }
}
