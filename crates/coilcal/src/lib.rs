//! The coil facility itself: the constant of each coil from a scalar magnetometer (NASA, "Measure Calibration Coil
//! Constants").
//!
//! B = k I + B0 along the coil's axis. A scalar magnetometer reads |B|; the sign is that of the current. Uncertainties from
//! scatter (type A) and from resistor and voltmeter (type B, common to all points) are kept apart and joined as JCGM 100
//! says.

mod constant;
mod departures;
mod error;
mod levels;
mod readings;
mod words;

pub use departures::FOUND_BELOW;
pub use error::Error;
pub use words::summary;

use common::{Axis, Document, procedure};

/// Finds the constants of the coils that were recorded, and writes them to `calibration.coils`; a coil without a
/// recording keeps what the document says of it.
pub fn run(mut document: Document) -> Result<Document, Error> {
    let recorded =
        document.recordings.iter().any(|recording| recording.procedure == procedure::COIL_CONSTANT);
    if !recorded {
        return Err(Error::Nothing);
    }
    for coil in Axis::ALL {
        let Some(readings) = readings::read(&document, coil)? else { continue };
        let found = constant::calibrate(&document, &readings)?;
        let coils = document.calibration.get_or_insert_default().coils.get_or_insert_default();
        let entry = coils.entry(coil).get_or_insert_default();
        let extra = std::mem::take(&mut entry.extra);
        *entry = found;
        entry.extra = extra;
    }
    Ok(document)
}
