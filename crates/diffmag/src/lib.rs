//! Two magnetometers side by side (the differential method): T = R η + d, rows are samples.
//!
//! η says how the test instrument is turned and scaled against the reference, d is the difference that no turn explains. Its
//! spectrum is fitted, and with it the intervals of η that hold for errors with memory.

mod difference;
mod error;
pub mod fourteen;
mod mutual;
mod regression;
mod series;
mod words;

pub use error::Error;
pub use words::summary;

use common::Document;

/// What is asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {}

/// Holds the test instrument against the reference and writes what is found to `calibration.differential`.
pub fn run(mut document: Document, _: &Options) -> Result<Document, Error> {
    let pair = series::read(&document)?;
    let fits = regression::fit(&pair)?;
    let found = regression::calibrate(&pair, &fits)?;
    let calibration = document.calibration.get_or_insert_default();
    let kept = calibration.differential.take().unwrap_or_default();
    let fourteen = mutual::parameters(&found, kept.known.as_ref())?.map(Box::new);
    let (known, extra) = (kept.known, kept.extra);
    calibration.differential = Some(common::DifferentialCalibration { known, fourteen, extra, ..found });
    Ok(document)
}
