//! Whether the calibration fitted again leaves as little as plain linear least squares of the same constants.

use common::number::significant;

use crate::Error;
use crate::fit::{Fit, Fitter};
use crate::model::{Model, State};
use crate::products::Projection;
use crate::whitening::NoiseModel;

/// A fit leaves at most this share of the rms that linear least squares leave.
const AS_LITTLE: f64 = 1.05;

/// What is to be said of a fit from a start that leaves more than linear least squares at the start, under the same
/// noise.
pub fn worse(
    model: &Model<'_>,
    start: &State,
    (fit, noise): (&Fit, &NoiseModel),
) -> Result<Option<String>, Error> {
    let begun = Fitter { model, noise }.at(start)?;
    let linear = Projection::of(&begun)?.screen().sum_of_squares();
    let ratio = (fit.cost / linear).sqrt();
    Ok((ratio > AS_LITTLE).then(|| {
        format!(
            "the calibration fitted again leaves {} times the residual of linear least squares of the same constants: it did not converge; give a calibration nearer to the true one",
            significant(ratio, 3)
        )
    }))
}
