//! The result in a few lines for people.

use common::number::{bare, counted, signed, significant};
use common::{Axis, CoilCalibration, Document, PerAxis, Quantity};
use std::fmt::Write;

/// What was found of each coil, with ± and units, and what looks wrong.
pub fn summary(document: &Document) -> String {
    let mut text = String::new();
    let coils = document.calibration.as_ref().and_then(|calibration| calibration.coils.as_ref());
    // Writing to a String cannot fail.
    for (axis, coil) in coils.into_iter().flat_map(PerAxis::iter) {
        constant(&mut text, axis, coil);
        for survey in &coil.surveys {
            let worst = &survey.worst_departure_nt;
            let _ = writeln!(
                text,
                "  survey \"{}\" of coil {axis}: largest departure {worst:+} nT at {} m, from {} nT at the centre",
                survey.recording,
                signed(&bare(survey.worst_position_m)),
                bare(survey.centre_nt.as_ref().map_or(0.0, Quantity::value))
            );
        }
        if let Some(coil) = &coil.gradient_coil {
            let change = signed(&significant(coil.change_a, 4));
            let _ = writeln!(
                text,
                "  gradient coil: {} A nulls this departure (a change of {change} A)",
                coil.current_a
            );
        }
    }
    let nulling = document.calibration.as_ref().and_then(|calibration| calibration.nulling.as_ref());
    for (name, site) in nulling.iter().flat_map(|nulling| &nulling.sites) {
        let Some(longest) = site.expected.last() else { continue };
        let rms: Vec<String> = longest.rms_nt.iter().map(|(axis, rms)| format!("{axis} {rms}")).collect();
        let _ =
            writeln!(text, "  nulling, {name}: rms {} nT from {}", rms.join(", "), band(&longest.band_hz));
        for series in &site.series {
            let Some(off_s) = series.uneven_s else { continue };
            let _ = writeln!(
                text,
                "    \"{}\": its times are uneven by up to {} s; the series was interpolated, and its white noise is underestimated",
                series.recording,
                significant(off_s, 2)
            );
        }
        for gap in &site.gaps_hz {
            let _ = writeln!(text, "    no recording covers {}, so it is not in the rms", band(gap));
        }
        for line in &site.lines {
            let name = line.name.as_deref().unwrap_or("no known source");
            let _ = writeln!(
                text,
                "    line at {} Hz in {}, sensor {}: {} nT, {name}",
                significant(line.frequency_hz, 5),
                line.recording,
                line.sensor,
                significant(line.amplitude_nt, 3)
            );
        }
    }
    if let Some(quietest) = nulling.and_then(|nulling| nulling.quietest.as_ref()) {
        let _ = writeln!(text, "  the quietest condition is {quietest}");
    }
    if !text.is_empty() {
        text += "  ± is one standard uncertainty; multiply by coverage_factor_95 in the document for a 95 % interval";
    }
    text
}

/// The ends of a band of frequencies.
fn band([low, high]: &[f64; 2]) -> String {
    format!("{} to {} Hz", significant(*low, 3), significant(*high, 3))
}

fn constant(text: &mut String, axis: Axis, coil: &CoilCalibration) {
    let (Some(constant), Some(offset), Some(fit)) =
        (&coil.constant_nt_per_a, &coil.offset_nt, &coil.constant)
    else {
        return;
    };
    let _ = writeln!(
        text,
        "coilcal: coil {axis}: {constant} nT/A, offset {offset:+} nT; {}, {} at {}, rms {} nT",
        fit.model,
        counted(fit.readings, "reading"),
        counted(fit.levels, "level"),
        significant(fit.rms_nt, 3)
    );
    for finding in &fit.findings {
        let _ = writeln!(text, "  {finding}");
    }
}
