use common::number::counted;
use thiserror::Error;

/// What a piece of physics returns.
pub type Result<T = (), E = Error> = std::result::Result<T, E>;

/// Why a recording cannot be predicted or corrected.
#[derive(Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Error {
    /// An orientation is not a rotation.
    #[error("found {found}; expected {expected}")]
    NotARotation { found: String, expected: String },
    /// An effect or the chain needs something that the recording does not hold.
    #[error("recording \"{recording}\": {who} needs {what}")]
    Missing { recording: String, who: String, what: String },
    /// An effect of the document is not in the catalogue, or its parameters are not as the catalogue says.
    #[error("found {found}; expected {expected}")]
    Unknown { index: usize, found: String, expected: String },
    /// An effect of the chain hides the field: many fields give one reading.
    #[error(
        "recording \"{recording}\": the model cannot be inverted through {effect} ({title}): many fields give the same reading"
    )]
    Hidden { recording: String, effect: String, title: String },
    /// The chain has no inverse for these readings.
    #[error(
        "recording \"{recording}\": the model cannot be inverted in {}, the first of them row {first}; {effects} may hide the field that made them",
        counted(*.rows, "row")
    )]
    NotInvertible { recording: String, rows: usize, first: usize, effects: String },
    /// The sensors leave a component of the field unread.
    #[error(
        "recording \"{recording}\": the sensors' axes lie in one plane, and the field across it is not read; expected three directions in calibration.axes.sensors.matrix"
    )]
    InOnePlane { recording: String },
}

impl Error {
    /// The error at a JSON path of the document or plan that it is about.
    pub fn at(self, path: &str) -> common::Error {
        match self {
            Error::NotARotation { found, expected } => common::Error::document(path, found, expected),
            Error::Unknown { index, found, expected } => {
                common::Error::document(format!("{path}.effects[{index}]"), found, expected)
            }
            Error::Missing { who, what, .. } => {
                common::Error::document(path, format!("nothing that {who} could use"), what)
            }
            other @ (Error::NotInvertible { .. } | Error::Hidden { .. } | Error::InOnePlane { .. }) => {
                common::Error::Unanswerable(other.to_string())
            }
        }
    }
}
