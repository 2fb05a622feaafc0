//! The result in a few lines for people.

use common::number::{counted, p_value, signed, significant, uncertain};
use common::{Axis, Document, Error, ReferenceOffset, ScalarCalibration, ScalarParameter};

/// What was found, with ± and units, and what looks wrong.
pub fn summary(document: &Document) -> String {
    let scalar = document.calibration.as_ref().and_then(|calibration| calibration.scalar.as_ref());
    scalar.map(|scalar| describe(scalar)).unwrap_or_default()
}

fn describe(scalar: &ScalarCalibration) -> String {
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
        lines.push(format!("{name}: {value} {unit}{}", with.unwrap_or_default()));
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
