//! The result in a few lines for people.

use common::{Axis, DifferentialFit, Document, Quantity};
use std::fmt::Write;

use crate::regression::p_of;

/// Spectra that agree worse than this by chance are not of the form that is fitted.
const UNLIKE_BELOW: f64 = 1e-3;
/// The independent interval is too narrow when the honest one is wider by this.
const NARROW: f64 = 1.5;

/// Which interval to quote.
pub fn quoted() -> String {
    "the weighted elements with `weighted_std`: both rest on the spectrum of the difference, flicker noise included; least \
     squares with N − 4 degrees of freedom takes the samples as independent"
        .into()
}

/// What looks wrong, or is worth knowing.
pub fn findings(fit: &DifferentialFit, told_below: f64) -> Vec<String> {
    let mut findings = Vec::new();
    let ratio = fit.elements.values().map(|e| e.std_noise / e.std_independent).fold(0.0, f64::max);
    if ratio > NARROW {
        findings.push(format!(
            "the errors have memory: intervals as if the samples were independent would be up to {ratio:.1} times too narrow"
        ));
    }
    for (axis, of) in fit.axes.iter() {
        if of.goodness_p < UNLIKE_BELOW {
            findings.push(format!(
                "axis {axis}: the difference is not A/f^α and white noise (p = {:.1e}); something else is in it",
                of.goodness_p
            ));
        }
        if p_of(&of.drift_nt_per_day) < told_below {
            findings
                .push(format!("axis {axis}: the difference drifts (p = {:.1e})", p_of(&of.drift_nt_per_day)));
        }
    }
    if let Some(clock) = &fit.clock {
        let (late, fast) = (p_of(&clock.offset_s), p_of(&clock.rate_ppm));
        if late < told_below {
            findings.push(format!(
                "the clocks differ (p = {late:.1e}); correct the times before the matrix is used"
            ));
        }
        if fast < told_below {
            findings.push(format!("the clocks run at different rates (p = {fast:.1e})"));
        }
    }
    if fit.missing > 0 {
        findings.push(format!(
            "{} samples lack a reading and stand on straight lines between their neighbours",
            fit.missing
        ));
    }
    findings
}

fn plus_minus(quantity: &Quantity, digits: usize) -> String {
    format!("{:+.digits$} ± {:.digits$}", quantity.value(), quantity.std().unwrap_or(0.0))
}

/// What was found, with ± and units.
pub fn summary(document: &Document) -> String {
    let mut text = String::new();
    let found = document.calibration.as_ref().and_then(|calibration| calibration.differential.as_ref());
    let Some(fit) = found.and_then(|found| found.fit.as_ref()) else { return text };
    // Writing to a String cannot fail.
    let _ = writeln!(text, "diffmag: \"{}\", {} samples of {} s", fit.recording, fit.samples, fit.step_s);
    for axis in Axis::ALL {
        let row: Vec<String> = Axis::ALL
            .iter()
            .filter_map(|from| fit.elements.get(&format!("{from}{axis}")))
            .map(|element| format!("{:+.6} ± {:.6}", element.weighted, element.weighted_std))
            .collect();
        let _ = writeln!(text, "  test {axis} from the reference's x, y, z: {}", row.join(", "));
    }
    for (axis, of) in fit.axes.iter() {
        let offset = found.and_then(|found| found.offset_nt.as_ref()?.get(axis));
        let _ = writeln!(
            text,
            "  test {axis}: offset {} nT, rms {:.3} nT, {:.2} ± {:.2} pT/√Hz at 1 Hz as f^{:.2}, drift {} nT a day",
            offset.map_or(String::new(), |offset| plus_minus(offset, 3)),
            of.rms_nt,
            1e3 * of.density_at_1hz_nt_per_sqrt_hz.value(),
            1e3 * of.density_at_1hz_nt_per_sqrt_hz.std().unwrap_or(0.0),
            -of.flicker_exponent.value(),
            plus_minus(&of.drift_nt_per_day, 4)
        );
    }
    if let Some(clock) = &fit.clock {
        let _ = writeln!(
            text,
            "  clock of the test instrument: {} s late, {} ppm",
            plus_minus(&clock.offset_s, 4),
            plus_minus(&clock.rate_ppm, 3)
        );
    }
    for finding in &fit.findings {
        let _ = writeln!(text, "    {finding}");
    }
    text
}
