//! The result in a few lines for people.

use common::number::{bare, counted, signed, significant};
use common::{Axis, CoilCalibration, Document, PerAxis, Quantity};

/// What was found of each coil, with ± and units, and what looks wrong.
pub fn summary(document: &Document) -> String {
    let mut lines = Vec::new();
    let coils = document.calibration.as_ref().and_then(|calibration| calibration.coils.as_ref());
    for (axis, coil) in coils.into_iter().flat_map(PerAxis::iter) {
        lines.extend(constant(axis, coil));
        for survey in &coil.surveys {
            let worst = &survey.worst_departure_nt;
            lines.push(format!(
                "  survey \"{}\" of coil {axis}: largest departure {worst:+} nT at {} m, from {} nT at the centre",
                survey.recording,
                signed(&bare(survey.worst_position_m)),
                bare(survey.centre_nt.as_ref().map_or(0.0, Quantity::value))
            ));
        }
        if let Some(coil) = &coil.gradient_coil {
            let change = signed(&significant(coil.change_a, 4));
            let current = &coil.current_a;
            lines.push(format!("  gradient coil: {current} A nulls this departure (a change of {change} A)"));
        }
    }
    let nulling = document.calibration.as_ref().and_then(|calibration| calibration.nulling.as_ref());
    for (name, site) in nulling.iter().flat_map(|nulling| &nulling.sites) {
        let Some(longest) = site.expected.last() else { continue };
        let rms: Vec<String> = longest.rms_nt.iter().map(|(axis, rms)| format!("{axis} {rms}")).collect();
        lines.push(format!("  nulling, {name}: rms {} nT from {}", rms.join(", "), band(&longest.band_hz)));
        for series in &site.series {
            let Some(off_s) = series.uneven_s else { continue };
            lines.push(format!(
                "    \"{}\": its times are uneven by up to {} s; the series was interpolated, and its white noise is underestimated",
                series.recording,
                significant(off_s, 2)
            ));
        }
        for gap in &site.gaps_hz {
            lines.push(format!("    no recording covers {}, so it is not in the rms", band(gap)));
        }
        for line in &site.lines {
            let (hz, nt) = (significant(line.frequency_hz, 5), significant(line.amplitude_nt, 3));
            let (recording, sensor) = (&line.recording, &line.sensor);
            let name = line.name.as_deref().unwrap_or("no known source");
            lines.push(format!("    line at {hz} Hz in {recording}, sensor {sensor}: {nt} nT, {name}"));
        }
    }
    let quietest = nulling.and_then(|nulling| nulling.quietest.as_ref());
    lines.extend(quietest.map(|quietest| format!("  the quietest condition is {quietest}")));
    if !lines.is_empty() {
        lines.push("  ± is one standard uncertainty; multiply by coverage_factor_95 in the document for a 95 % interval".into());
    }
    lines.join("\n")
}

fn band([low, high]: &[f64; 2]) -> String {
    format!("{} to {} Hz", significant(*low, 3), significant(*high, 3))
}

fn constant(axis: Axis, coil: &CoilCalibration) -> Vec<String> {
    let (Some(constant), Some(offset), Some(fit)) =
        (&coil.constant_nt_per_a, &coil.offset_nt, &coil.constant)
    else {
        return Vec::new();
    };
    let head = format!(
        "coilcal: coil {axis}: {constant} nT/A, offset {offset:+} nT; {}, {} at {}, rms {} nT",
        fit.model,
        counted(fit.readings, "reading"),
        counted(fit.levels, "level"),
        significant(fit.rms_nt, 3)
    );
    std::iter::once(head).chain(fit.findings.iter().map(|finding| format!("  {finding}"))).collect()
}
