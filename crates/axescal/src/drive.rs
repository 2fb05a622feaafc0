//! What the calculated fields of the coils rest on.

use common::uncertainty::{self, By};
use common::{Axis, Document, Quantity, Uncertainty, procedure};

/// A coil's constant, nT/A.
pub(crate) fn constant(document: &Document, coil: Axis) -> f64 {
    let of = document.calibration.as_ref().and_then(|calibration| calibration.coil(coil));
    of.and_then(|of| of.constant_nt_per_a.as_ref()).map_or(1.0, Quantity::value)
}

/// What the calculated field of a coil rests on in the recordings that are read here.
pub(crate) fn drive(document: &Document, coil: Axis) -> By {
    let mine = document.recordings.iter().filter(|one| one.procedure == procedure::AXES_ORIENTATION);
    uncertainty::drive(document, coil, constant(document, coil), mine)
}

/// Standard uncertainties of a coil's calculated field, as a share of the drive and as a constant, nT; None
/// where none is stated.
pub(crate) fn drive_std(document: &Document, joint: &Uncertainty, coil: Axis) -> [Option<f64>; 2] {
    let covariance = joint.covariance_by(&drive(document, coil));
    let std = |which: usize| Some(covariance[(which, which)].sqrt()).filter(|std| *std > 0.0);
    [std(0).map(|std| std / constant(document, coil).abs()), std(1)]
}
