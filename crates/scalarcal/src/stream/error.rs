use thiserror::Error;

/// Why rows cannot be taken, or pieces not be joined.
#[derive(Debug, Error, PartialEq)]
pub enum Error {
    /// The columns of a batch are not of one length.
    #[error("a batch with columns of {found} and {expected} rows; all must be as long as `time_s`")]
    Lengths {
        /// Rows of the odd column.
        found: usize,
        /// Rows of the time.
        expected: usize,
    },
    /// A time is missing.
    #[error("row {row}: found no time; every row needs one, also where readings are missing")]
    NoTime {
        /// Row from 0.
        row: u64,
    },
    /// Time does not rise.
    #[error(
        "row {row}: found {time_s} s at or before the row above it; expected times that rise (sort the rows, take doubles out)"
    )]
    Backwards {
        /// Row from 0.
        row: u64,
        /// Its time, s.
        time_s: f64,
    },
    /// A time is far from any.
    #[error(
        "row {row}: found {time_s} s; expected seconds of a clock, less than 10¹² (is it in another unit?)"
    )]
    Far {
        /// Row from 0.
        row: u64,
        /// Its time, s.
        time_s: f64,
    },
    /// There are no rows.
    #[error("no rows; expected at least one")]
    Empty,
    /// Pieces of other columns.
    #[error(
        "pieces with readings in {first} and in {second}; expected the same unit and the same kind of reference in all"
    )]
    Unlike {
        /// Of one piece.
        first: String,
        /// Of another.
        second: String,
    },
    /// Two pieces cover the same time.
    #[error(
        "two pieces cover {from_s} s to {to_s} s; expected each time in one piece (was one given twice?)"
    )]
    Overlap {
        /// From, s.
        from_s: f64,
        /// To, s.
        to_s: f64,
    },
    /// A file that is no piece of this kind.
    #[error("no piece of scalarcal: {0}")]
    Format(String),
}

impl From<Error> for common::Error {
    fn from(error: Error) -> Self {
        common::Error::Request(error.to_string())
    }
}
