//! The result in a few lines for people.

use common::number::{counted, figures, p_value, signed, significant, vector};
use common::{AxesCalibration, AxesDirections, Axis, Document, PerAxis, Quantity};
use physics::frames::ARCSEC;
use std::fmt::Write;

use crate::Options;

/// What a run with these options found, with ± and units, and what looks wrong.
pub fn summary(document: &Document, options: &Options) -> String {
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let found = if options.is_subset() { axes.and_then(|axes| axes.subset.as_deref()) } else { axes };
    found.map(describe).unwrap_or_default()
}

fn describe(axes: &AxesCalibration) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    if let Some(fit) = &axes.fit {
        let _ = writeln!(
            text,
            "axescal: {} in {}, {}; rank {} of {}, rms {} nT, noise {} nT ({})",
            counted(fit.readings, "reading"),
            counted(axes.orientations.len(), "orientation"),
            fit.method,
            fit.rank,
            fit.unknowns,
            significant(fit.rms_nt, 4),
            significant(fit.noise_nt, 4),
            fit.noise_source
        );
    }
    if let Some(fit) = axes.fit.as_ref().filter(|fit| !fit.iterations.is_empty()) {
        let each: Vec<String> = fit
            .iterations
            .iter()
            .map(|step| {
                format!("{} nT, turned {}\"", significant(step.rms_nt, 4), significant(step.turn_arcsec, 2))
            })
            .collect();
        let _ = writeln!(text, "  steps (rms before each): {}", each.join("; "));
    }
    directions(&mut text, "sensor", "SEN", axes.sensors.as_ref());
    directions(&mut text, "coil", "GEO", axes.coils.as_ref());
    constants(&mut text, "residual field (GEO)", axes.residual_field_nt.as_ref());
    constants(&mut text, "corrections to the offsets in calibration.sensors", axes.offsets_nt.as_ref());
    if let Some(scales) = &axes.scales {
        let _ = writeln!(text, "  scales: {}", scales.verdict);
    }
    if let Some(pair) = &axes.pair {
        let _ = writeln!(
            text,
            "  without the unit-length constraint: rank {} of 6, sensor {}\" and coil {}\" from the directions above, misfit {} nT",
            pair.unconstrained_rank,
            significant(pair.sensor_difference_arcsec, 3),
            significant(pair.coil_difference_arcsec, 3),
            significant(pair.incompatibility_rms_nt, 3)
        );
    }
    for phase in &axes.phases {
        let _ = writeln!(
            text,
            "  phase of sensor {} at {} Hz: {:+} rad",
            phase.sensor,
            significant(phase.drive_hz, 6),
            phase.phase_rad
        );
    }
    for assumption in &axes.assumptions {
        let bound = match (assumption.arcsec_per_nt, assumption.arcsec_per_arcsec) {
            (Some(nt), _) => {
                format!("; each nT of it would turn a direction by up to {}\"", significant(nt, 3))
            }
            (_, Some(arcsec)) => {
                let arcsec = significant(arcsec, 3);
                format!(
                    "; an uncertainty of 1\" in the orientations makes a direction uncertain by up to {arcsec}\""
                )
            }
            _ => String::new(),
        };
        let _ = writeln!(text, "  assumed: {}{bound}", assumption.assumed);
    }
    for doubt in &axes.doubtful {
        let _ = writeln!(
            text,
            "  outlier: orientation {} (\"{}\", row {}), coil {}, sensor {}: {} nT from the prediction of the others \
             (t = {}, adjusted {})",
            doubt.orientation,
            doubt.recording,
            doubt.row,
            doubt.coil,
            doubt.sensor,
            signed(&significant(doubt.leave_one_out_nt, 4)),
            significant(doubt.t, 3),
            p_value(doubt.p_adjusted)
        );
    }
    for finding in &axes.findings {
        let _ = writeln!(text, "  note: {finding}");
    }
    text +=
        "  ± is one standard uncertainty; multiply by coverage_factor_95 in the document for a 95 % interval";
    text
}

fn directions(text: &mut String, kind: &str, frame: &str, part: Option<&AxesDirections>) {
    let Some(part) = part else { return };
    for axis in Axis::ALL {
        let column = match (&part.matrix, &part.directions) {
            (Some(matrix), _) => {
                Some([matrix[0][axis.index()], matrix[1][axis.index()], matrix[2][axis.index()]])
            }
            (None, Some(directions)) => directions.get(axis).copied(),
            (None, None) => None,
        };
        let Some(column) = column else { continue };
        let std = part.std_arcsec.as_ref().and_then(|std| std.get(axis));
        let direction = vector(column, std.unwrap_or(0.0) * ARCSEC);
        let std = std.map_or(String::new(), |std| format!(" ± {}\"", figures(std, 2)));
        let _ = writeln!(text, "  {kind} {axis} in {frame}: {direction}{std}");
    }
    if let Some(angles) = &part.non_orthogonality_arcsec {
        let each: Vec<String> = angles.iter().map(|(pair, angle)| format!("{pair} {angle:+}\"")).collect();
        let _ = writeln!(text, "  {kind}s off orthogonal: {}", each.join(", "));
    }
}

fn constants(text: &mut String, name: &str, values: Option<&PerAxis<Quantity>>) {
    let Some(values) = values else { return };
    let each: Vec<String> = values.iter().map(|(axis, value)| format!("{axis} {value:+}")).collect();
    let _ = writeln!(text, "  {name}: {} nT", each.join(", "));
}
