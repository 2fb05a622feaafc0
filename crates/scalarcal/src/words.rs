//! The result in a few lines for people.

use common::number::{counted, p_value, significant, uncertain};
use common::{Document, ScalarCalibration};
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
    if let Some(amplitude) = scalar.noise.flicker_nt2_per_hz_at_1hz {
        let _ = writeln!(
            text,
            "  noise with memory: {} nT²/Hz at 1 Hz, as 1/f^α with α = {}; white {} nT",
            significant(amplitude, 3),
            significant(scalar.noise.flicker_exponent.unwrap_or(1.0), 3),
            significant(scalar.noise.white_rms_nt.unwrap_or(0.0), 3)
        );
    }
    for parameter in &scalar.parameters {
        let with = match (scalar.beforehand.as_ref(), parameter.std_with_known) {
            (Some(known), Some(std)) if !known.used => {
                format!(" (± {} with what was known)", significant(std, 2))
            }
            _ => String::new(),
        };
        let _ = writeln!(
            text,
            "  {}: {} {}{with}",
            parameter.name,
            uncertain(parameter.value, parameter.std),
            parameter.unit
        );
    }
    if let Some(weakest) = &scalar.weakest {
        let std = weakest.std_nt.map(|std| format!(" (± {} nT)", significant(std, 2))).unwrap_or_default();
        let _ = writeln!(text, "  shown least: {}{std}; {}", weakest.words, weakest.remedy);
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
            "  against what was known: χ² = {} with {} degrees of freedom, {}",
            significant(test.chi_squared, 3),
            test.degrees_of_freedom,
            p_value(test.p_value)
        );
    }
    if let Some(test) = &scalar.stability {
        let _ = writeln!(
            text,
            "  {} of the time against all: {}",
            counted(test.windows.len(), "part"),
            p_value(test.p_value)
        );
    }
    for (reason, count) in &scalar.left_out {
        let _ = writeln!(text, "  left out: {} ({reason})", counted(*count as usize, "row"));
    }
    for finding in &scalar.findings {
        let _ = writeln!(text, "  note: {finding}");
    }
    text
}
