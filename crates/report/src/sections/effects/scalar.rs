//! Findings of scalarcal.

use common::{ScalarCalibration, ScalarParameter};

use super::{LEFT_OUT, NOT_SHOWN, Rule, UNCERTAINTY, before};
use crate::Effect;

/// What findings on a calibration by magnitude do.
pub const RULES: [Rule<ScalarCalibration>; 8] = [
    ("the reference reads ", |scalar, _| {
        Effect::nt(scalar.reference_offset.as_ref().map(|reference| reference.offset_nt.value()))
    }),
    ("the readings contradict the prior calibration of the sensors", |scalar, _| contradicted(scalar)),
    ("the calibration is not constant in time", |scalar, _| changed(scalar)),
    ("outliers (p", |_, words| Effect::nt(before(words, " nT in "))),
    ("the magnitude of the field is unknown", |_, _| NOT_SHOWN),
    ("make the uncertainties too small", |_, _| UNCERTAINTY),
    ("include the iron of the body", |_, _| NOT_SHOWN),
    (" left out: others have one", |_, _| LEFT_OUT),
];

/// What the new calibration changes at the readings, rms; without it the misfit in standard uncertainties.
fn contradicted(scalar: &ScalarCalibration) -> Effect {
    let rms = scalar.rms_before_nt.map(|before| (before.powi(2) - scalar.rms_nt.powi(2)).max(0.0).sqrt());
    let pull = scalar.beforehand.as_ref().map(|test| (test.chi_squared / test.degrees_of_freedom).sqrt());
    rms.map_or(Effect::std(pull), Effect::nt)
}

/// The parameter of a part of the time that is farthest from that of all for its uncertainty.
fn changed(scalar: &ScalarCalibration) -> Effect {
    let parts = scalar.stability.iter().flat_map(|stability| &stability.windows);
    let each = parts.flat_map(|part| {
        let values = part.values.iter().zip(&part.std).zip(&scalar.parameters);
        values.map(|((value, std), whole)| (whole, value - whole.value, ((value - whole.value) / std).abs()))
    });
    let known = each.filter(|(.., pull)| pull.is_finite());
    let most = known.max_by(|a, b| a.2.total_cmp(&b.2));
    most.map_or(Effect::NOT_HELD, |(parameter, change, pull)| in_field(parameter, change, pull))
}

/// A change of a parameter by what it does; where its unit does not tell, in standard uncertainties.
fn in_field(parameter: &ScalarParameter, change: f64, pull: f64) -> Effect {
    match parameter.unit.as_str() {
        "nT" => Effect::nt(change),
        "arcsec" => Effect::arcsec(change),
        "nT/V" | "nT/nT" => Effect::nt(50_000.0 * change / parameter.value),
        _ => Effect::std(pull),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::said_by;
    use super::*;

    #[test]
    fn phrases() {
        said_by("scalarcal", &RULES);
    }
}
