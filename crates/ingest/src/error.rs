use common::Error as Fault;
use tables::Place;
use thiserror::Error;

/// Why a file is not taken.
#[derive(Debug, Error)]
pub enum Error {
    /// A file is not as it must be, or cannot be read; with file, line and column.
    #[error(transparent)]
    Table(#[from] tables::Error),
    /// The document or the request is wrong.
    #[error(transparent)]
    Document(#[from] Fault),
}

impl Error {
    /// A fault at a place of a file.
    pub(crate) fn at(
        file: &str,
        place: Place,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        let (found, expected) = (found.into(), expected.into());
        Error::Table(tables::Error::Data { source_name: file.into(), place, found, expected })
    }

    /// A request that cannot be met.
    pub(crate) fn request(message: impl Into<String>) -> Self {
        Error::Document(Fault::Request(message.into()))
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        match error {
            Error::Document(error) => error,
            Error::Table(tables::Error::File { path, action, source }) => {
                Fault::File { path, action, source }
            }
            Error::Table(error) => Fault::Request(error.to_string()),
        }
    }
}
