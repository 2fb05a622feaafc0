//! A recording with the chain that predicts it.

use common::{Axis, Document, Quantity, Recording};
use nalgebra::Vector3;

use crate::{Basic, Context, Error, References};

/// What a document says of one recording: simulation, fit and diagnosis predict it from the same.
#[derive(Clone, Debug)]
pub struct Setting<'a> {
    /// The constants: of the chain in coils, or of two magnetometers where the recording is differential.
    pub basic: Basic,
    /// Times, drive, temperatures, orientation.
    pub context: Context<'a>,
}

impl<'a> Setting<'a> {
    /// Reads a recording, with the field that axescal found to be left in the coils.
    pub fn of(document: &Document, recording: &'a Recording, references: References) -> Result<Self, Error> {
        let mut context = Context::new(document, recording, references)?;
        if context.reference_nt.is_some() {
            return Ok(Self { basic: Basic::differential(document), context });
        }
        if context.in_coils {
            let left = residual_field(document);
            context.ambient_nt.iter_mut().for_each(|field| *field += left);
        }
        let basic = Basic::found(document, context.unit);
        match basic.undetermined() {
            Some(path) => Err(context.missing("the prediction", &format!("a number where {path} has null"))),
            None => Ok(Self { basic, context }),
        }
    }
}

/// What axescal found to be left in the coils without drive, GEO, nT.
fn residual_field(document: &Document) -> Vector3<f64> {
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let found = axes.and_then(|axes| axes.residual_field_nt.as_ref());
    Vector3::from(Axis::ALL.map(|axis| found.and_then(|f| f.get(axis)).map_or(0.0, Quantity::value)))
}
