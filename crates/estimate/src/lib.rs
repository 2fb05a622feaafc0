//! Estimation without magnetics.
//!
//! Residuals are always observed less predicted, each divided by its standard deviation, so that a
//! sum of squares is a χ². Prior knowledge enters as further rows of the same kind.

pub mod allan;
mod bins;
pub mod cadence;
pub mod correlated;
pub mod cosine;
pub mod cross_spectrum;
mod dot;
pub mod even;
pub mod events;
pub mod exact;
pub mod gauss_newton;
pub mod grouped;
pub mod haar;
pub mod hac;
pub mod influence;
pub mod lag;
pub mod line_search;
pub mod linear;
pub mod mixture;
pub mod normality;
pub mod periodogram;
mod plans;
pub mod positive;
pub mod resample;
pub mod robust;
mod scoring;
pub mod screen;
pub mod sine;
pub mod sources;
pub mod spectral;
pub mod spectrum;
pub mod stats;
pub mod svd;
pub mod triangle;
pub mod tsqr;
pub mod wander;
pub mod whittle;

pub use dot::dot;
pub use gauss_newton::{Fit, Linear, Options, Problem, Step, linearised, minimise, solve, solve_near};
pub use svd::Svd;

use thiserror::Error;

/// Why an estimate could not be made.
#[derive(Debug, Error)]
pub enum Error {
    /// The matrix has entries that are not finite, or the decomposition failed.
    #[error(
        "the singular value decomposition of a {rows}x{columns} matrix failed ({reason}); the input has entries that are not finite, or that are absurdly large"
    )]
    Decomposition {
        /// Rows of the matrix.
        rows: usize,
        /// Columns of the matrix.
        columns: usize,
        /// What was seen.
        reason: String,
    },
    /// The iteration stopped without reaching a minimum.
    #[error(
        "no minimum after {iterations} steps; the last one still moved the prediction by {last_shift:.3e} standard deviations"
    )]
    NotConverged {
        /// Steps made.
        iterations: usize,
        /// Weighted shift of the last step.
        last_shift: f64,
    },
    /// There are too few readings.
    #[error("{found} readings for {unknowns} unknowns; at least {unknowns} are needed")]
    TooFew {
        /// Readings given.
        found: usize,
        /// Unknowns asked for.
        unknowns: usize,
    },
    /// A series that has no spectrum.
    #[error("no spectrum of a series {0}")]
    Series(&'static str),
    /// A density that no noise has.
    #[error(
        "the density of the noise is {found} at {frequency_hz} Hz; it must be finite and above zero from 0 Hz to the Nyquist frequency: hold it constant below the lowest frequency of its law"
    )]
    Density {
        /// Where.
        frequency_hz: f64,
        /// What was found.
        found: f64,
    },
}
