//! Constant and gradient of each coil, from a scalar magnetometer (NASA, "Calibration of Test Facility").
//!
//! B = k I + B0 along the coil's axis. A scalar magnetometer reads |B|; the sign is that of the current.
//! Uncertainties from scatter (type A) and from resistor and voltmeter (type B, common to all points) are
//! kept apart and joined as JCGM 100 says.

mod constant;
mod departures;
mod gradient;
mod nulling;
mod readings;
mod scatter;
mod words;

pub use common::Error;
pub use words::summary;

use clap::Args;
use common::{Axis, Document, Uncertainty, procedure};
use program::number;

type Result<T, E = Error> = std::result::Result<T, E>;

/// What is asked of coilcal.
#[derive(Args, Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Distance from a coil's centre at which the field error is stated, m
    #[arg(long, value_name = "M", default_value_t = 0.05, value_parser = number::not_negative)]
    pub off_centre_m: f64,
    /// Nyquist frequency of the instrument that will measure in the coils, Hz
    #[arg(long, value_name = "HZ", default_value_t = 50.0, value_parser = number::positive)]
    pub nyquist_hz: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { off_centre_m: 0.05, nyquist_hz: 50.0 }
    }
}

impl Options {
    /// What the history records of the request.
    pub fn arguments(&self) -> Vec<String> {
        vec![format!("--off-centre-m={}", self.off_centre_m), format!("--nyquist-hz={}", self.nyquist_hz)]
    }
}

/// The procedures that are read here.
pub const PROCEDURES: [&str; 3] =
    [procedure::COIL_CONSTANT, procedure::COIL_GRADIENT, procedure::NULLING_RESIDUAL];

/// Where no recording is for this stage.
const NOTHING: &str = "no recording with the procedure `coil_constant`, `coil_gradient` or `nulling_residual`; coilcal needs currents (or voltages across a resistor) with `reference_nt`, or readings in the nulled field";

/// Finds constants and gradients of the coils that were recorded (`calibration.coils`; others keep theirs),
/// and what the nulling leaves (`calibration.nulling`).
pub fn run(document: Document, options: &Options) -> Result<Document> {
    calibrated(document, options)
        .map_err(|error| error.of_fit(|why| format!("the coil constant could not be fitted: {why}")))
}

fn calibrated(mut document: Document, options: &Options) -> Result<Document> {
    if !document.recordings.iter().any(|recording| PROCEDURES.contains(&recording.procedure.as_str())) {
        return Err(Error::Request(NOTHING.into()));
    }
    let mut joint = Uncertainty::of(&document)?;
    for coil in Axis::ALL {
        let constant = match readings::read(&document, coil)? {
            Some(readings) => Some(constant::calibrate(&document, &readings, &mut joint)?),
            None => None,
        };
        let surveys = gradient::surveys(&document, coil, options.off_centre_m)?;
        if constant.is_none() && surveys.is_empty() {
            continue;
        }
        let coils = document.calibration.get_or_insert_default().coils.get_or_insert_default();
        let entry = coils.entry(coil).get_or_insert_default();
        if let Some(found) = constant {
            let kept = std::mem::replace(entry, found);
            (entry.surveys, entry.gradient_coil, entry.extra) =
                (kept.surveys, kept.gradient_coil, kept.extra);
        }
        if !surveys.is_empty() {
            entry.gradient_coil = gradient::gradient_coil(&surveys);
            entry.surveys = surveys;
        }
    }
    if !joint.sources.is_empty() {
        document.calibration.get_or_insert_default().uncertainty = Some(joint);
    }
    if let Some(nulling) = nulling::residual(&document, options.nyquist_hz)? {
        document.calibration.get_or_insert_default().nulling = Some(Box::new(nulling));
    }
    Ok(document)
}
