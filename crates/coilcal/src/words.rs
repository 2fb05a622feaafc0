//! The result in a few lines for people.

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
                "  survey \"{}\" of coil {axis}: {:+.3} ± {:.3} nT at {:+.4} m is the farthest from the centre's {:.1} nT",
                survey.recording,
                worst.value(),
                worst.std().unwrap_or(0.0),
                survey.worst_position_m,
                survey.centre_nt.as_ref().map_or(0.0, Quantity::value)
            );
        }
        if let Some(coil) = &coil.gradient_coil {
            let (value, std) = (coil.current_a.value(), coil.current_a.std().unwrap_or(0.0));
            let _ = writeln!(
                text,
                "  gradient coil: {value:.5} ± {std:.5} A brings that to zero ({:+.5} A)",
                coil.change_a
            );
        }
    }
    let nulling = document.calibration.as_ref().and_then(|calibration| calibration.nulling.as_ref());
    for (name, site) in nulling.iter().flat_map(|nulling| &nulling.sites) {
        let Some(longest) = site.expected.last() else { continue };
        let rms: Vec<String> = longest
            .rms_nt
            .iter()
            .map(|(axis, rms)| format!("{axis} {:.3} ± {:.3}", rms.value(), rms.std().unwrap_or(0.0)))
            .collect();
        let [low, high] = longest.band_hz;
        let _ = writeln!(text, "  nulling, {name}: rms {} nT from {low:.2e} to {high:.1} Hz", rms.join(", "));
        for [from, to] in &site.gaps_hz {
            let _ =
                writeln!(text, "    nothing was recorded from {from:.3} to {to:.3} Hz: it is not in the rms");
        }
        for line in &site.lines {
            let name = line.name.as_deref().unwrap_or("no known source");
            let _ = writeln!(
                text,
                "    line at {:.3} Hz in {}, sensor {}: {:.3} nT, {name}",
                line.frequency_hz, line.recording, line.sensor, line.amplitude_nt
            );
        }
    }
    if let Some(quietest) = nulling.and_then(|nulling| nulling.quietest.as_ref()) {
        let _ = writeln!(text, "  the quietest condition is {quietest}");
    }
    text
}

fn constant(text: &mut String, axis: Axis, coil: &CoilCalibration) {
    let (Some(constant), Some(offset), Some(fit)) =
        (&coil.constant_nt_per_a, &coil.offset_nt, &coil.constant)
    else {
        return;
    };
    let std = |quantity: &Quantity| quantity.std().unwrap_or(0.0);
    let _ = writeln!(
        text,
        "coilcal: coil {axis}: {:.4} ± {:.4} nT/A, offset {:+.3} ± {:.3} nT; {}, {} readings at {} levels, rms {:.3} nT",
        constant.value(),
        std(constant),
        offset.value(),
        std(offset),
        fit.model,
        fit.readings,
        fit.levels,
        fit.rms_nt
    );
    for finding in &fit.findings {
        let _ = writeln!(text, "  {finding}");
    }
}
