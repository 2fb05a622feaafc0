//! The result in a few lines for people.

use common::number::{counted, figures, p_value, signed, significant, vector};
use common::{AxesCalibration, AxesDirections, AxesFit, Axis, Document, DoubtfulReading, PerAxis, Quantity};
use physics::frames::ARCSEC;

use crate::Options;

/// What a run with these options found, with ± and units, and what looks wrong.
pub fn summary(document: &Document, options: &Options) -> String {
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let found = if options.is_subset() { axes.and_then(|axes| axes.subset.as_deref()) } else { axes };
    found.map(describe).unwrap_or_default()
}

fn describe(axes: &AxesCalibration) -> String {
    let mut lines = Vec::new();
    if let Some(fit) = &axes.fit {
        let (readings, orientations) =
            (counted(fit.readings, "reading"), counted(axes.orientations.len(), "orientation"));
        let [rms, noise] = [fit.rms_nt, fit.noise_nt].map(|nt| significant(nt, 4));
        let AxesFit { method, rank, unknowns, noise_source, .. } = fit;
        lines.push(format!(
            "axescal: {readings} in {orientations}, {method}; rank {rank} of {unknowns}, rms {rms} nT, noise {noise} nT ({noise_source})"
        ));
        let each = fit.iterations.iter().map(|step| {
            format!("{} nT, turned {}\"", significant(step.rms_nt, 4), significant(step.turn_arcsec, 2))
        });
        let each: Vec<String> = each.collect();
        if !each.is_empty() {
            lines.push(format!("  steps (rms before each): {}", each.join("; ")));
        }
    }
    lines.extend(directions("sensor", "SEN", axes.sensors.as_ref()));
    lines.extend(directions("coil", "GEO", axes.coils.as_ref()));
    lines.extend(constants("residual field (GEO)", axes.residual_field_nt.as_ref()));
    lines.extend(constants("corrections to the offsets in calibration.sensors", axes.offsets_nt.as_ref()));
    lines.extend(axes.scales.iter().map(|scales| format!("  scales: {}", scales.verdict)));
    lines.extend(axes.pair.iter().map(|pair| {
        let each = [pair.sensor_difference_arcsec, pair.coil_difference_arcsec, pair.incompatibility_rms_nt];
        let ([sensor, coil, misfit], rank) = (each.map(|one| significant(one, 3)), pair.unconstrained_rank);
        format!(
            "  without the unit-length constraint: rank {rank} of 6, sensor {sensor}\" and coil {coil}\" from the directions above, misfit {misfit} nT"
        )
    }));
    lines.extend(axes.phases.iter().map(|phase| {
        let hz = significant(phase.drive_hz, 6);
        format!("  phase of sensor {} at {hz} Hz: {:+} rad", phase.sensor, phase.phase_rad)
    }));
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
        lines.push(format!("  assumed: {}{bound}", assumption.assumed));
    }
    lines.extend(axes.doubtful.iter().map(|doubt| {
        let DoubtfulReading { orientation, recording, row, coil, sensor, leave_one_out_nt, t, p_adjusted } = doubt;
        let (off, t) = (signed(&significant(*leave_one_out_nt, 4)), significant(*t, 3));
        let p = p_value(*p_adjusted);
        format!(
            "  outlier: orientation {orientation} (\"{recording}\", row {row}), coil {coil}, sensor {sensor}: {off} nT from the prediction of the others \
             (t = {t}, adjusted {p})"
        )
    }));
    lines.extend(axes.findings.iter().map(|finding| format!("  note: {finding}")));
    lines.push(
        "  ± is one standard uncertainty; multiply by coverage_factor_95 in the document for a 95 % interval"
            .into(),
    );
    lines.join("\n")
}

fn directions(kind: &str, frame: &str, part: Option<&AxesDirections>) -> Vec<String> {
    let Some(part) = part else { return Vec::new() };
    let mut lines = Vec::new();
    for axis in Axis::ALL {
        let Some(column) = part.direction(axis) else { continue };
        let std = part.std_arcsec.as_ref().and_then(|std| std.get(axis));
        let direction = vector(column, std.unwrap_or(0.0) * ARCSEC);
        let std = std.map_or(String::new(), |std| format!(" ± {}\"", figures(std, 2)));
        lines.push(format!("  {kind} {axis} in {frame}: {direction}{std}"));
    }
    if let Some(angles) = &part.non_orthogonality_arcsec {
        let each: Vec<String> = angles.iter().map(|(pair, angle)| format!("{pair} {angle:+}\"")).collect();
        lines.push(format!("  {kind}s off orthogonal: {}", each.join(", ")));
    }
    lines
}

fn constants(name: &str, values: Option<&PerAxis<Quantity>>) -> Option<String> {
    let each: Vec<String> = values?.iter().map(|(axis, value)| format!("{axis} {value:+}")).collect();
    Some(format!("  {name}: {} nT", each.join(", ")))
}
