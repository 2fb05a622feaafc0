//! Two magnetometers side by side (the differential method): T = R η + d, rows are samples.
//!
//! η says how the test instrument is turned and scaled against the reference, d is the difference that no
//! turn explains. Its spectrum is fitted, and with it the intervals of η that hold for errors with memory.
//! Before that the instruments are put on one grid of times, their clocks compared, and steps and spikes kept
//! out.
//!
//! - `paired` says which columns recorded beside the pair the test instrument follows, how the clocks differ, and
//!   which rows are steps or disturbed. The columns stand between drift and steps in the design; rows that are left
//!   out get their most likely readings, so that T = R η + d keeps its shape. `confirmed` leaves the events that the
//!   final fit confirms.
//! - `regression` is weighted by the spectrum of the residual, in cosine transforms. The noise is fitted by
//!   restricted likelihood, so that the power a drift takes from the lowest frequencies is not missing from
//!   it.
//! - The weights reach into the band where the field is weak; there, filters and noise of the reference pull
//!   η. `alike` therefore removes octaves from the shortest periods on, until one has the matrix of the
//!   longer ones.
//! - `drift/weighed` asks the engine `explain` for the probability of a drift beside noise alone.
//! - `contributions` fits each axis again by ordinary least squares with one thing left in at a time (clock,
//!   columns, steps, spikes, drift): what it adds to the rms orders the findings. `shown` averages the
//!   difference into points for plots, so that `report` only draws.
//! - `stream` answers the same question for series that do not fit into memory: sums that can be merged take
//!   the place of transforms.

mod calibration;
mod confirmed;
mod files;
mod matrix;
mod noise;
mod octave;
mod shown;
pub mod stream;
mod words;

pub use common::Error;
pub use files::Columns;
pub use matrix::fourteen;
pub use words::summary;

use crate::matrix::{across, alike, bands, constancy, mutual, regression, stability, windows};
use crate::noise::{contributions, difference, drift, reference_noise};

use common::Document;
use paired::{Asked, residual};

/// What is asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Move the test instrument's readings to the reference's clock.
    pub correct_clock: bool,
}

/// Holds the test instrument against the reference and writes what is found to `calibration.differential`.
pub fn run(mut document: Document, options: &Options) -> Result<Document, Error> {
    let recorded = joined::read(&document)?;
    let covariates = joined::beside(&document, &recorded.recordings);
    let asked =
        Asked { covariates: covariates.clone(), correct_clock: options.correct_clock, ..Asked::default() };
    let found = paired::find(&recorded, asked, &|_| ())?;
    let held_out = found.held_out();
    let paired::Found { raw, follows, mut prepared, .. } = found;
    let mut fits = regression::fit(&prepared.pair, &follows)?;
    while let Some(fewer) = confirmed::confirmed(&prepared, &raw, &fits)? {
        prepared = fewer;
        fits = regression::fit(&prepared.pair, &follows)?;
    }
    let mut found = calibration::calibrate((&recorded, &raw), &prepared, &fits, held_out)?;
    let level = regression::level(&prepared.pair, &fits);
    if let Some(fit) = &mut found.fit {
        fit.stability = stability::of(&level, &fits)?;
        fit.series = shown::series(&covariates, &recorded, &prepared, &fits, fit);
    }
    let levels_nt = std::array::from_fn(|axis| residual::of_levels(&recorded, axis));
    reference_noise::add(&level, &fits, levels_nt, &mut found)?;
    if let Some(clock) = prepared.clock.as_ref().filter(|clock| clock.corrected) {
        paired::adopt::clock(&mut document, &raw, clock, "diffmag");
    }
    let calibration = document.calibration.get_or_insert_default();
    let kept = calibration.differential.take().unwrap_or_default();
    let fourteen = mutual::parameters(&found, kept.known.as_ref())?.map(Box::new);
    let (known, extra) = (kept.known, kept.extra);
    calibration.differential = Some(common::DifferentialCalibration { known, fourteen, extra, ..found });
    Ok(document)
}
