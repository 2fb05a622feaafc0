//! Estimation without magnetics.
//!
//! Residuals are always observed less predicted, each divided by its standard deviation, so that a
//! sum of squares is a χ². Prior knowledge enters as further rows of the same kind.
//!
//! *Linear fits:* `linear`, what decomposes matrices (`svd`, `positive`), rows without end (`exact`, `triangle`,
//! `tsqr`), what is read off a fit (`hac`, `influence`). `correlated` makes generalised least-squares steps under
//! a covariance, `mixture` combines several noise models by the quantiles of the mixture, `wander` rotates once so
//! that every size of the wander is diagonal.
//!
//! *Nonlinear fits* are one damped Gauss-Newton iteration, [`minimise`]. A prior is a further row with the
//! residual (value − known)/σ; a common error stays common because it is one unknown. [`solve`] is the
//! iteration for dense rows, with minimum-norm steps by the SVD, damped only where a whole step does not
//! descend. diagnose has many rows and costly derivatives: it takes its steps from products of rows and keeps
//! derivatives from step to step. sensorcal steps to the mean under several covariances, which minimises no
//! single sum of squares; its steps are shortened instead. `robust` weighs bad readings down.
//!
//! Other iterations solve other problems: `scoring` and the fit of diffmag's `stream` maximise a likelihood
//! whose variances are the unknowns, within limits; the time constant of an exponential drift is one unknown,
//! for `line_search::climb`; `physics::Inverter` solves equations row by row.
//!
//! *Series by their times* are `cadence`, `even`, `grouped`, `lag` and `resample`.
//!
//! *Sines* of known frequency are fitted by least squares; unknown frequencies, along time or codes, are
//! found by one transform and golden sections (`sine`). Those of `periodogram` stay on the Fourier ordinates,
//! the only place where the noise beside a line is known.
//!
//! *Events* are found by two matched filters for steps and spikes (`events`): `Search` knows the spectrum of
//! the noise of one long even series, `Departures` takes a whitened residual at any times beside all else
//! that is fitted. diffmag decides in rounds which instrument has an event and whether it lasts; diagnose
//! lets each compete for the evidence. `screen` weighs groups of columns.
//!
//! *Spectra* of even series are `spectrum`, `cross_spectrum` and `periodogram`; `whittle` and `sources` fit noise
//! to them, `spectral` and `cosine` regress under such noise. Cosine transforms whiten long series without a matrix
//! of their length: a Fourier transform would take drift and noise as periodic, and for flicker noise, which is
//! not, the variance of a straight drift would be far too small. The first 64 coefficients have the exact
//! covariance of power-law noise that did not begin with the recording.

pub mod allan;
pub mod cadence;
pub mod correlated;
pub mod cosine;
pub mod cross_spectrum;
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

pub use gauss_newton::{Fit, Linear, Options, Problem, Step, linearised, minimise, solve};
pub use linear::{add_gram, dot, gram, gram_of, mirrored};
pub use svd::Svd;

use errors::Told;
use thiserror::Error;

/// Why an estimate could not be made.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum Error {
    /// The matrix has entries that are not finite, or the decomposition failed.
    #[error(
        "the singular value decomposition of a {rows}x{columns} matrix failed ({reason}); the input has entries that are not finite, or that are absurdly large"
    )]
    Decomposition { rows: usize, columns: usize, reason: String },
    /// The iteration stopped without reaching a minimum.
    #[error(
        "no minimum after {iterations} steps; the last one still moved the prediction by {last_shift:.3e} standard deviations"
    )]
    NotConverged { iterations: usize, last_shift: f64 },
    /// There are too few readings.
    #[error("{found} readings for {unknowns} unknowns; at least {unknowns} are needed")]
    TooFew { found: usize, unknowns: usize },
    /// A series that has no spectrum.
    #[error("no spectrum of a series {0}")]
    Series(&'static str),
}

impl Told for Error {
    fn told(self) -> errors::Error {
        errors::Error::Fit(self.to_string())
    }
}
