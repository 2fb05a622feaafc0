//! Absolute measurements of an observatory, and the baselines of its variometer.
//!
//! Observers find the declination and inclination of the field with a magnetometer on the telescope of a theodolite, in
//! four positions each, so that the errors of the instrument cancel; a scalar magnetometer gives the magnitude. Together
//! with a variometer's readings at the same moments they give its baseline values, between which a baseline is adopted.
//!
//! Source: J. Jankowski and C. Sucksdorff, IAGA Guide for Magnetic Measurements and Observatory Practice (1996),
//! chapters 5 and 7; INTERMAGNET Technical Reference Manual, version 5.
//!
//! - `read` takes the circles and what the `variometer` read beside them, `fit` makes a measurement of them by least
//!   squares, `sets` all of them with one uncertainty of the circle, and finds outliers. `checks` says what is wrong with
//!   a sheet that fits nothing.
//! - `adopted` is the baseline between the measurements: trends of more and less freedom, steps, and columns that it
//!   follows, weighed by their evidence (`evidence`). `joint` puts the measurements into the joint uncertainty.

mod adopted;
mod causes;
mod checks;
mod evidence;
mod fit;
mod joint;
mod read;
mod sets;
mod start;
mod variometer;
mod words;

pub use common::Error;
pub use words::summary;

use common::{AbsoluteCalibration, Code, Document, Findings, procedure};
use physics::frames::ARCSEC;

/// The procedures that are read here.
pub const PROCEDURES: [&str; 2] = [procedure::ABSOLUTE, procedure::VARIOMETER];

/// Finds the field and the baseline values of every measurement, and writes them to `calibration.absolute`.
/// Errors: no recording that can be used; a measurement that is incomplete, or that fits no field.
pub fn run(mut document: Document) -> Result<Document, Error> {
    let variometer = variometer::variometer(&document)?;
    let sets = read::sets(&document, variometer.as_ref())?;
    if sets.is_empty() {
        return Err(Error::Request("no recording with the procedure `absolute`; it needs the circles of a theodolite (horizontal_deg, vertical_deg) with residual_nt, the reading of its magnetometer".into()));
    }
    let measured = sets::measured(&document, sets)?;
    let components = measured.sets[0].0.components;
    let mut findings = Findings::default();
    let adopted = match components {
        Some(components) => {
            let (adopted, told) = adopted::adopted(&document, &measured, components)?;
            findings = told;
            Some(adopted)
        }
        None => {
            let words = "no variometer: the field is taken as constant during each measurement, and there is no baseline";
            findings.push(Code::NotDetermined.said(words));
            None
        }
    };
    let result = AbsoluteCalibration {
        components: components.map(|components| components.name().to_string()),
        variometer: variometer.map_or_else(Vec::new, |variometer| variometer.recordings),
        circle_arcsec: measured.known.circle / ARCSEC,
        degrees_of_freedom: Some(measured.freedom).filter(|freedom| freedom.is_finite()),
        sets: (0..measured.sets.len()).map(|at| measured.written(at, adopted.as_ref())).collect(),
        adopted,
        findings,
        ..AbsoluteCalibration::default()
    };
    joint::put(&mut document, &measured, &result.sets)?;
    document.calibration.get_or_insert_default().absolute = Some(Box::new(result));
    Ok(document)
}
