//! What looks wrong, in sentences.

use common::ScalarCalibration;
use common::number::{counted, p_value, significant};

use crate::model::Parameter;
use crate::read::Source;
use crate::solved::Solved;

/// What has a smaller probability by chance is said.
const TOLD_BELOW: f64 = 0.001;
/// Sensitivities that differ by more than this factor have an odd one among them.
const UNLIKE: f64 = 3.0;
/// Cosines between axes above this are hardly those of three sensors at right angles.
const OBLIQUE: f64 = 0.5;

/// Sentences about a calibration.
pub fn of(solved: &Solved, scalar: &ScalarCalibration) -> Vec<String> {
    let mut all = Vec::new();
    let reference = scalar.reference_offset.as_ref();
    if let Some(reference) = reference.filter(|reference| told(reference.p_value) && !reference.fitted) {
        all.push(format!(
            "the reference reads {:+} nT too high ({}), or another error is constant with the field: a constant error of the reference biases the sensitivities. --reference-offset fits it",
            reference.offset_nt,
            p_value(reference.p_value)
        ));
    }
    if let Some(test) = scalar.beforehand.as_ref().filter(|test| told(test.p_value)) {
        all.push(format!(
            "the readings contradict the prior calibration of the sensors (χ² = {} with {} degrees of freedom, {}): the \
             sensors have changed, the body has a field, or the reference is wrong",
            significant(test.chi_squared, 3),
            test.degrees_of_freedom,
            p_value(test.p_value)
        ));
    }
    if let Some(test) = scalar.stability.as_ref().filter(|test| told(test.p_value)) {
        all.push(format!(
            "the calibration is not constant in time: {} differ from it (F test, {}); check `stability.windows`, and temperatures and currents (--with)",
            counted(test.windows.len(), "part"),
            p_value(test.p_value)
        ));
    }
    if solved.model.place(&Parameter::Magnitude).is_some() && solved.sources == [Source::Constant] {
        all.push(
            "the magnitude of the field is unknown, so only ratios of the sensitivities are observable: their mean is fixed at the nominal value"
                .into(),
        );
    }
    let state = &solved.found.state;
    let sizes: Vec<f64> = (0..3).map(|axis| (state[axis] * solved.scales.sensitivity[axis]).abs()).collect();
    let (low, high) =
        (sizes.iter().copied().fold(f64::INFINITY, f64::min), sizes.iter().copied().fold(0.0, f64::max));
    if high > UNLIKE * low {
        all.push(format!(
            "sensitivities differ by a factor of {}: is a sensor in another range, or disturbed?",
            significant(high / low, 2)
        ));
    }
    if state[6..9].iter().any(|cosine| cosine.abs() > OBLIQUE) {
        all.push("the axes are far from orthogonal: were two channels mixed up, or is one sensor a combination of others?".into());
    }
    all
}

/// Whether a probability is so small that it is said.
fn told(p_value: f64) -> bool {
    p_value < TOLD_BELOW
}
