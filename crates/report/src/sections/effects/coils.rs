//! Findings of coilcal.

use common::{CoilCalibration, CoilFit};

use super::{NOT_SHOWN, Rule, UNDECIDED, largest};
use crate::Effect;

/// What a coil's findings do.
pub const RULES: [Rule<CoilCalibration>; 4] = [
    ("not a straight line: ", |coil, _| bend(coil)),
    ("would explain the readings about as well", |_, _| UNDECIDED),
    ("the levels scatter more than repeated readings", |coil, _| {
        Effect::nt(coil.constant.as_ref().map(|fit| fit.rms_nt))
    }),
    ("the current was recorded in one direction only", |_, _| NOT_SHOWN),
];

/// What is fitted beside constant and offset: the largest distance of the fitted field from their line, among
/// the levels.
fn bend(coil: &CoilCalibration) -> Effect {
    let constants = coil.constant_nt_per_a.as_ref().zip(coil.offset_nt.as_ref());
    let Some((fit, (k, offset))) = coil.constant.as_ref().zip(constants) else { return Effect::NOT_HELD };
    let CoilFit { residuals, .. } = fit.as_ref();
    let levels = residuals.drive_a.iter().zip(residuals.field_nt.iter().zip(&residuals.residual_nt));
    let line = |drive: f64| k.value() * drive + offset.value();
    Effect::nt(largest(levels.map(|(drive, (field, residual))| field - residual - line(*drive))))
}

#[cfg(test)]
mod tests {
    use super::super::tests::said_by;
    use super::*;

    #[test]
    fn phrases() {
        said_by("coilcal", &RULES);
    }
}
