use thiserror::Error;

/// Why rows cannot be taken, or pieces not be joined.
#[derive(Debug, Error, PartialEq)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Error {
    /// The columns of a batch are not of one length.
    #[error("a batch with columns of {found} and {expected} rows; all must be as long as `time_s`")]
    Lengths { found: usize, expected: usize },
    /// A time is missing in a row, counted from 0 over all batches.
    #[error("row {row}: found no time; every row needs one, also where readings are missing")]
    NoTime { row: u64 },
    /// Time does not rise at a row, counted from 0 over all batches.
    #[error(
        "row {row}: found {time_s} s at or before the row above it; expected times that rise (sort the rows, take doubles out)"
    )]
    Backwards { row: u64, time_s: f64 },
    /// There is nothing to merge.
    #[error("no pieces; expected at least one line of what `stream --partial` writes")]
    Empty,
    /// Pieces that cannot be of one series.
    #[error("pieces {first} and {second}; expected {expected}")]
    Unlike { first: String, second: String, expected: &'static str },
    /// Pieces that cover the same time.
    #[error(
        "two pieces cover the same time, from {from_s} s to {to_s} s; each row may be in one piece only (was one given twice? Of more than {most} pieces with holes between, neighbours are merged first)",
        most = crate::MOST
    )]
    Overlap { from_s: f64, to_s: f64 },
    /// A text that is no piece of this kind.
    #[error("no piece of {kind}: {reason}")]
    Format { kind: &'static str, reason: String },
}

impl common::Told for Error {}
