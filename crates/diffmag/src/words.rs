//! The result in a few lines for people.

use common::{Axis, DifferentialFit, Document, FourteenParameters, Magnetometer, Quantity};
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
    if let Some(fourteen) = found.and_then(|found| found.fourteen.as_ref()) {
        text += &mutual(fourteen);
    }
    for finding in &fit.findings {
        let _ = writeln!(text, "    {finding}");
    }
    text
}

/// How the instruments stand to each other.
fn mutual(fourteen: &FourteenParameters) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = match (fourteen.known, fourteen.assumed) {
        (_, true) => {
            writeln!(text, "  if the reference is orthogonal with equal scales (nobody said; see `known`):")
        }
        (Magnetometer::Reference, false) => writeln!(text, "  with the reference as known:"),
        (Magnetometer::Test, false) => writeln!(text, "  with the test instrument as known:"),
    };
    let angles: Vec<String> = fourteen
        .angles
        .iter()
        .filter(|(name, angle)| angle.std_arcsec > 0.0 && !fourteen.undetermined.contains(name))
        .map(|(name, angle)| format!("{name} {:.5}° ± {:.2}″", angle.value_deg, angle.std_arcsec))
        .collect();
    let _ = writeln!(text, "    {}", angles.join(", "));
    let ratios: Vec<String> = fourteen
        .ratios
        .iter()
        .filter(|(_, ratio)| ratio.std() != Some(0.0))
        .map(|(name, ratio)| {
            format!("{} {:.6} ± {:.6}", name.replace('_', "/"), ratio.value(), ratio.std().unwrap_or(0.0))
        })
        .collect();
    let _ = writeln!(text, "    scales {}", ratios.join(", "));
    let (whose, angles) = match fourteen.known {
        Magnetometer::Reference => ("test instrument", &fourteen.test_non_orthogonality_arcsec),
        Magnetometer::Test => ("reference", &fourteen.reference_non_orthogonality_arcsec),
    };
    let angles: Vec<String> =
        angles.iter().map(|(pair, angle)| format!("{pair} {}″", plus_minus(angle, 1))).collect();
    let _ = writeln!(text, "    {whose} off right angles: {}", angles.join(", "));
    text
}
