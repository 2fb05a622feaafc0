//! The result in a few lines for people.

use common::number::{counted, p_value, signed, significant, uncertain};
use common::{Axis, Code, Document, Error, Finding, ReferenceOffset, ScalarCalibration, ScalarParameter};

use crate::model::Parameter;
use crate::read::Source;
use crate::solved::Solved;

/// What has a smaller probability by chance is said.
const TOLD_BELOW: f64 = 0.001;
/// Sensitivities that differ by more than this factor have an odd one among them.
const UNLIKE: f64 = 3.0;
/// Cosines between axes above this are hardly those of three sensors at right angles.
const OBLIQUE: f64 = 0.5;

/// What was found, with ± and units, and what looks wrong.
pub fn summary(document: &Document) -> String {
    let scalar = document.calibration.as_ref().and_then(|calibration| calibration.scalar.as_ref());
    let Some(scalar) = scalar else { return String::new() };
    let three = |value: f64| significant(value, 3);
    let rows = |count: u64| counted(count as usize, "row");
    let before = scalar.rms_before_nt.map(|rms| format!("{} → ", significant(rms, 4))).unwrap_or_default();
    let mut lines = vec![format!(
        "scalarcal: {} in {} against {}; residual {before}{} nT rms",
        rows(scalar.rows),
        counted(scalar.recordings.len(), "recording"),
        scalar.reference,
        significant(scalar.rms_nt, 4)
    )];
    if let Some(vector) = &scalar.vector {
        lines.push(format!(
            "with its direction at {}: residual {} nT along the field, {} nT across it; attitude {}\"{}",
            counted(vector.moments as usize, "moment"),
            three(vector.rms_along_nt),
            three(vector.rms_across_nt),
            significant(vector.attitude_std_arcsec, 2),
            if vector.across_only { "; only the transverse residual is used" } else { "" }
        ));
    }
    let noise = scalar.vector.as_ref().and_then(|vector| vector.noise.as_ref()).unwrap_or(&scalar.noise);
    if let Some(amplitude) = noise.flicker_nt2_per_hz_at_1hz {
        let unmeasured = scalar.memory_of.as_deref() == Some("magnitude");
        lines.push(format!(
            "{}: {} nT²/Hz at 1 Hz, as 1/f^α with α = {}; white {} nT",
            if unmeasured { "unmeasured changes of the magnitude" } else { "correlated noise" },
            three(amplitude),
            three(noise.flicker_exponent.unwrap_or(1.0)),
            three(noise.white_rms_nt.unwrap_or(0.0))
        ));
    }
    let unused = scalar.beforehand.as_ref().is_some_and(|known| !known.used);
    for ScalarParameter { name, unit, value, std, std_with_known, .. } in &scalar.parameters {
        let with = std_with_known.filter(|_| unused);
        let with = with.map(|std| format!(" (± {} with prior knowledge)", significant(std, 2)));
        let value = uncertain(*value, *std);
        let is_size = ["sensitivity", "magnitude"].iter().any(|size| name.starts_with(size));
        let value = if is_size { value } else { signed(&value) };
        // The unit of an effect's parameter stands in its name.
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        lines.push(format!("{name}: {value}{unit}{}", with.unwrap_or_default()));
    }
    if let Some(weakest) = &scalar.weakest {
        let std = weakest.std_nt.map(|std| format!(" (± {} nT)", significant(std, 2))).unwrap_or_default();
        lines.push(format!("least determined: {}{std}; {}", weakest.words, weakest.remedy));
    }
    if let Some(ReferenceOffset { offset_nt, p_value: p, fitted }) = &scalar.reference_offset {
        let fitted = if *fitted { "fitted" } else { "by the readings" };
        lines.push(format!("offset of the reference, {fitted}: {offset_nt:+} nT ({})", p_value(*p)));
    }
    if let Some(test) = &scalar.beforehand {
        let (freedom, p) = (test.degrees_of_freedom, p_value(test.p_value));
        let chi_squared = three(test.chi_squared);
        lines.push(format!(
            "against prior knowledge: χ² = {chi_squared} with {freedom} degrees of freedom, {p}"
        ));
    }
    if let Some(test) = &scalar.stability {
        let parts = counted(test.windows.len(), "part");
        lines.push(format!("{parts} of the recording against the whole: {}", p_value(test.p_value)));
    }
    if let Some(body) = &scalar.body {
        let hard = Axis::ALL.map(|axis| body.hard_iron_nt.get(axis).map(|one| format!("{one:+}")));
        let soft: Vec<String> =
            body.soft_iron_ppm.iter().map(|(name, one)| format!("{name} {one:+}")).collect();
        lines.push(format!(
            "iron of the body: {} nT in SEN; {} ppm of the field ({})",
            hard.map(Option::unwrap_or_default).join(", "),
            soft.join(", "),
            p_value(body.p_value)
        ));
    }
    let left_out = scalar.left_out.iter();
    lines.extend(left_out.map(|(reason, count)| format!("left out: {} ({reason})", rows(*count))));
    lines.extend(scalar.findings.iter().map(|finding| format!("note: {finding}")));
    lines.push("± is one standard uncertainty".into());
    lines.join("\n  ")
}

/// What is said of a fit that failed.
pub(crate) fn failed(error: Error) -> Error {
    error.of_fit(|why| {
        format!(
            "the calibration failed: {why}. Check for outliers (--robust), and for a reference in another unit"
        )
    })
}

pub(crate) fn findings(solved: &Solved, scalar: &ScalarCalibration) -> Vec<Finding> {
    let mut all = Vec::new();
    let reference = scalar.reference_offset.as_ref();
    if let Some(reference) = reference.filter(|reference| told(reference.p_value) && !reference.fitted) {
        all.push(Code::ReferenceOffset.said(format!(
            "the reference reads {:+} nT too high ({}), or another error is constant with the field: a constant error of the reference biases the sensitivities. --reference-offset fits it",
            reference.offset_nt,
            p_value(reference.p_value)
        )));
    }
    if let Some(test) = scalar.beforehand.as_ref().filter(|test| told(test.p_value)) {
        all.push(Code::PriorContradicted.said(format!(
            "the readings contradict the prior calibration of the sensors (χ² = {} with {} degrees of freedom, {}): the \
             sensors have changed, the body has a field, or the reference is wrong",
            significant(test.chi_squared, 3),
            test.degrees_of_freedom,
            p_value(test.p_value)
        )));
    }
    if let Some(test) = scalar.stability.as_ref().filter(|test| told(test.p_value)) {
        all.push(Code::NotConstant.said(format!(
            "the calibration is not constant in time: {} differ from it (F test, {}); check `stability.windows`, and temperatures and currents (--with)",
            counted(test.windows.len(), "part"),
            p_value(test.p_value)
        )));
    }
    if solved.model.place(&Parameter::Magnitude).is_some() && solved.sources == [Source::Constant] {
        all.push(
            Code::MagnitudeUnknown.said("the magnitude of the field is unknown, so only ratios of the sensitivities are observable: their mean is fixed at the nominal value"),
        );
    }
    let state = &solved.found.state;
    let sizes: Vec<f64> =
        (0..3).map(|axis| (state[axis] * solved.given.scales.sensitivity[axis]).abs()).collect();
    let (low, high) =
        (sizes.iter().copied().fold(f64::INFINITY, f64::min), sizes.iter().copied().fold(0.0, f64::max));
    if high > UNLIKE * low {
        all.push(Code::UnequalSensitivities.said(format!(
            "sensitivities differ by a factor of {}: is a sensor in another range, or disturbed?",
            significant(high / low, 2)
        )));
    }
    if state[6..9].iter().any(|cosine| cosine.abs() > OBLIQUE) {
        all.push(Code::NotOrthogonal.said("the axes are far from orthogonal: were two channels mixed up, or is one sensor a combination of others?"));
    }
    all
}

/// Whether a probability is so small that it is said.
fn told(p_value: f64) -> bool {
    p_value < TOLD_BELOW
}
