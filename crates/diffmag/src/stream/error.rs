use common::number::significant;
use thiserror::Error;

/// Why rows cannot be taken, or pieces not be joined.
#[derive(Debug, Error, PartialEq)]
pub enum Error {
    /// As with every series.
    #[error(transparent)]
    Piece(#[from] partial::Error),
    /// A row does not stand on the grid.
    #[error(
        "row {row}: found {time_s} s, {} of a step from the grid of {step_s} s; expected less than 0.4 (check the step, and the clock for jumps)",
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
    /// The step is no step.
    #[error("a step of {0} s; expected a positive number of seconds")]
    Step(f64),
    /// The times do not show a step.
    #[error(
        "the first {rows} times have no common step of up to six digits (nor the inverse of such a rate); state the step, or resample: series resample --step S"
    )]
    NoStep {
        /// Rows looked at.
        rows: usize,
    },
}

impl common::Told for Error {}
