use thiserror::Error;

/// Why rows cannot be taken, or pieces not be joined.
#[derive(Debug, Error, PartialEq)]
pub enum Error {
    /// As with every series.
    #[error(transparent)]
    Piece(#[from] partial::Error),
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
}

impl common::Told for Error {}
