use common::number::significant;
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
        /// Row from 0 over all batches.
        row: u64,
    },
    /// A row does not stand on the grid.
    #[error(
        "row {row}: found {time_s} s, {} of a step from the grid of {step_s} s; expected less than 0.4 (is the step right? does the clock jump?)",
        significant(*.off, 2)
    )]
    OffGrid {
        /// Row from 0 over all batches.
        row: u64,
        /// Its time, s.
        time_s: f64,
        /// How far from its place, in steps.
        off: f64,
        /// The step, s.
        step_s: f64,
    },
    /// Time does not rise.
    #[error(
        "row {row}: found {time_s} s at or before the row above it; expected times that rise (sort the rows, take doubles out)"
    )]
    Backwards {
        /// Row from 0 over all batches.
        row: u64,
        /// Its time, s.
        time_s: f64,
    },
    /// The step is no step.
    #[error("a step of {0} s; expected a positive number of seconds")]
    Step(f64),
    /// The times do not show a step.
    #[error(
        "the first {rows} times show no even step of up to six digits (or one over such a rate); state the step, or make one: series resample --step S"
    )]
    NoStep {
        /// Rows looked at.
        rows: usize,
    },
    /// There are no rows.
    #[error("no rows; expected at least one")]
    Empty,
    /// Pieces of unlike grids.
    #[error("pieces on unlike grids: every {0} s and every {1} s; state the same step when they are made")]
    Unlike(String, String),
    /// Pieces that hold the same samples.
    #[error(
        "two pieces cover the same time, from {from_s} s to {to_s} s; each sample may be in one piece only"
    )]
    Overlap {
        /// From, s.
        from_s: f64,
        /// To, s.
        to_s: f64,
    },
    /// A file that is no piece of this kind.
    #[error("no piece of diffmag: {0}")]
    Format(String),
}

impl From<Error> for common::Error {
    fn from(error: Error) -> Self {
        common::Error::Request(error.to_string())
    }
}
