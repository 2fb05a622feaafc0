//! The result in a few lines for people.

use common::number::{counted, p_value, signed, significant, uncertain};
use common::{Axis, Document, Error, ScalarCalibration};
use std::fmt::Write;

/// What was found, with ± and units, and what looks wrong.
pub fn summary(document: &Document) -> String {
    let scalar = document.calibration.as_ref().and_then(|calibration| calibration.scalar.as_ref());
    scalar.map(|scalar| describe(scalar)).unwrap_or_default()
}

fn describe(scalar: &ScalarCalibration) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let before = scalar.rms_before_nt.map(|rms| format!("{} → ", significant(rms, 4))).unwrap_or_default();
    let _ = writeln!(
        text,
        "scalarcal: {} in {} against {}; residual {before}{} nT rms",
        counted(scalar.rows as usize, "row"),
        counted(scalar.recordings.len(), "recording"),
        scalar.reference,
        significant(scalar.rms_nt, 4)
    );
    if let Some(vector) = &scalar.vector {
        let _ = writeln!(
            text,
            "  with its direction at {}: residual {} nT along the field, {} nT across it; attitude {}\"{}",
            counted(vector.moments as usize, "moment"),
            significant(vector.rms_along_nt, 3),
            significant(vector.rms_across_nt, 3),
            significant(vector.attitude_std_arcsec, 2),
            if vector.across_only { "; only the transverse residual is used" } else { "" }
        );
    }
    let noise = scalar.vector.as_ref().and_then(|vector| vector.noise.as_ref()).unwrap_or(&scalar.noise);
    if let Some(amplitude) = noise.flicker_nt2_per_hz_at_1hz {
        let _ = writeln!(
            text,
            "  {}: {} nT²/Hz at 1 Hz, as 1/f^α with α = {}; white {} nT",
            match scalar.memory_of.as_deref() {
                Some("magnitude") => "unmeasured changes of the magnitude",
                _ => "correlated noise",
            },
            significant(amplitude, 3),
            significant(noise.flicker_exponent.unwrap_or(1.0), 3),
            significant(noise.white_rms_nt.unwrap_or(0.0), 3)
        );
    }
    for parameter in &scalar.parameters {
        let with = match (scalar.beforehand.as_ref(), parameter.std_with_known) {
            (Some(known), Some(std)) if !known.used => {
                format!(" (± {} with prior knowledge)", significant(std, 2))
            }
            _ => String::new(),
        };
        let value = uncertain(parameter.value, parameter.std);
        let is_change = !["sensitivity", "magnitude"].iter().any(|size| parameter.name.starts_with(size));
        let _ = writeln!(
            text,
            "  {}: {} {}{with}",
            parameter.name,
            if is_change { signed(&value) } else { value },
            parameter.unit
        );
    }
    if let Some(weakest) = &scalar.weakest {
        let std = weakest.std_nt.map(|std| format!(" (± {} nT)", significant(std, 2))).unwrap_or_default();
        let _ = writeln!(text, "  least determined: {}{std}; {}", weakest.words, weakest.remedy);
    }
    if let Some(reference) = &scalar.reference_offset {
        let fitted = if reference.fitted { "fitted" } else { "by the readings" };
        let _ = writeln!(
            text,
            "  offset of the reference, {fitted}: {:+} nT ({})",
            reference.offset_nt,
            p_value(reference.p_value)
        );
    }
    if let Some(test) = &scalar.beforehand {
        let _ = writeln!(
            text,
            "  against prior knowledge: χ² = {} with {} degrees of freedom, {}",
            significant(test.chi_squared, 3),
            test.degrees_of_freedom,
            p_value(test.p_value)
        );
    }
    if let Some(test) = &scalar.stability {
        let _ = writeln!(
            text,
            "  {} of the recording against the whole: {}",
            counted(test.windows.len(), "part"),
            p_value(test.p_value)
        );
    }
    if let Some(body) = &scalar.body {
        let nt = |axis: Axis| body.hard_iron_nt.get(axis).map(|one| format!("{one:+}")).unwrap_or_default();
        let _ = writeln!(
            text,
            "  iron of the body: {}, {}, {} nT in SEN; {} ({})",
            nt(Axis::X),
            nt(Axis::Y),
            nt(Axis::Z),
            body.soft_iron_ppm
                .iter()
                .map(|(name, one)| format!("{name} {one:+}"))
                .collect::<Vec<_>>()
                .join(", ")
                + " ppm of the field",
            p_value(body.p_value)
        );
    }
    for (reason, count) in &scalar.left_out {
        let _ = writeln!(text, "  left out: {} ({reason})", counted(*count as usize, "row"));
    }
    for finding in &scalar.findings {
        let _ = writeln!(text, "  note: {finding}");
    }
    text += "  ± is one standard uncertainty";
    text
}

/// What is said of a fit that failed.
pub(crate) fn failed(error: Error) -> Error {
    error.of_fit(|why| {
        format!(
            "the calibration failed: {why}. Check for outliers (--robust), and for a reference in another unit"
        )
    })
}
