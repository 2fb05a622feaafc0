//! The result in a few lines for people.

use common::{
    Axis, CrossFieldFit, Document, ErrorBudget, OffsetDrift, PerAxis, Quantity, SensorCalibration,
    SensorNoise, TemperatureFit, TemperatureOfPart,
};
use std::fmt::Write;

/// What was found of each sensor, with ± and units, and what looks wrong.
pub fn summary(document: &Document) -> String {
    let mut text = String::new();
    let calibration = document.calibration.as_ref();
    let sensors = calibration.and_then(|calibration| calibration.sensors.as_ref());
    for (axis, sensor) in sensors.into_iter().flat_map(PerAxis::iter) {
        of(&mut text, axis, sensor);
    }
    for extremum in calibration.iter().flat_map(|calibration| &calibration.common_extrema) {
        line(
            &mut text,
            &format!(
                "{} of all sensors stands still at {} degC of the {} (p = {:.2}): a good temperature to hold",
                extremum.quantity,
                plus_minus(&extremum.temperature_c, 1),
                extremum.part,
                extremum.p_value
            ),
        );
    }
    if !text.is_empty() {
        line(
            &mut text,
            "  ± is one standard uncertainty; coverage_factor_95 in the document makes it a 95 % interval",
        );
    }
    text
}

// Writing to a String cannot fail.
fn line(text: &mut String, what: &str) {
    let _ = writeln!(text, "{what}");
}

/// `6401.2000 ± 0.0030`
fn plus_minus(quantity: &Quantity, digits: usize) -> String {
    format!("{:.digits$} ± {:.digits$}", quantity.value(), quantity.std().unwrap_or(0.0))
}

/// `+0.310 ± 0.030`
fn signed(quantity: &Quantity, digits: usize) -> String {
    format!("{:+.digits$} ± {:.digits$}", quantity.value(), quantity.std().unwrap_or(0.0))
}

fn of(text: &mut String, axis: Axis, sensor: &SensorCalibration) {
    let volts = sensor.sensitivity_nt_per_v.as_ref().map(|k| (k, "nT/V"));
    let k = volts.or(sensor.sensitivity_nt_per_nt.as_ref().map(|k| (k, "nT/nT")));
    let mut head = format!("sensorcal: sensor {axis}:");
    if let Some((k, unit)) = k {
        let digits = if unit == "nT/V" { 4 } else { 8 };
        let _ = write!(head, " {} {unit}", plus_minus(k, digits));
    }
    if let Some(offset) = &sensor.offset_nt {
        let _ = write!(head, ", offset {} nT", signed(offset, 3));
    }
    if let Some(fit) = &sensor.sensitivity {
        let _ = write!(head, "; {}, {} readings, rms {:.3} nT", fit.model, fit.readings, fit.noise.rms_nt);
    }
    line(text, &head);
    let mut findings: Vec<&String> = sensor.sensitivity.iter().flat_map(|fit| &fit.findings).collect();
    if let Some(reversal) = &sensor.reversal {
        let pairs: usize = reversal.recordings.iter().map(|one| one.pairs.row.len()).sum();
        let turn = &reversal.imperfect_turn;
        line(
            text,
            &format!(
                "  reversals: offset {} nT from {pairs} pairs; a turn {}° off would move it by at most {:.3} nT",
                signed(&reversal.offset_nt, 4),
                turn.angle_deg,
                turn.bound_nt
            ),
        );
        findings.extend(&reversal.findings);
    }
    if let Some(noise) = &sensor.noise {
        line(text, &noise_line(noise));
        findings.extend(&noise.findings);
    }
    if let Some(temperature) = &sensor.temperature {
        temperature_lines(text, temperature);
        findings.extend(&temperature.findings);
    }
    if let Some(cross) = &sensor.cross_field {
        line(text, &cross_line(cross));
        findings.extend(&cross.findings);
    }
    if let Some(drift) = &sensor.drift {
        line(text, &drift_line(drift));
        findings.extend(&drift.findings);
    }
    if let Some(budget) = sensor.budget.iter().rev().find(|budget| budget.warmer_k == 0.0) {
        line(text, &budget_line(budget));
    }
    for finding in findings {
        line(text, &format!("    {finding}"));
    }
}

fn noise_line(noise: &SensorNoise) -> String {
    let flicker = match noise.flicker_below_nt2_per_hz {
        Some(bound) => format!("flicker below {:.1} pT/√Hz at 1 Hz", 1e3 * bound.sqrt()),
        None => format!(
            "{:.2} ± {:.2} pT/√Hz at 1 Hz, as f^-{}",
            1e3 * noise.density_at_1hz_nt_per_sqrt_hz.value(),
            1e3 * noise.density_at_1hz_nt_per_sqrt_hz.std().unwrap_or(0.0),
            plus_minus(&noise.flicker_exponent, 3)
        ),
    };
    let white = match noise.white_below_nt {
        Some(bound) => format!("white below {bound:.4} nT a reading"),
        None => format!("white {} nT a reading", plus_minus(&noise.white_rms_nt, 4)),
    };
    let band = noise.bands.first().map_or(String::new(), |band| {
        let [low, high] = band.band_hz;
        format!("; flicker rms {} nT from {low:.1e} to {high:.1e} Hz", plus_minus(&band.flicker_rms_nt, 4))
    });
    format!("  noise: {flicker}; {white}{band}")
}

fn temperature_lines(text: &mut String, fit: &TemperatureFit) {
    let mut part = |name: &str, of: &TemperatureOfPart| {
        line(
            text,
            &format!(
                "  {name} from {:.0} to {:.0} degC: the field that is read moves by {} ppm/K{}, and by {} nT/K{}",
                of.range_c[0],
                of.range_c[1],
                signed(&of.sensitivity_ppm_per_k, 3),
                curvature(&of.sensitivity_ppm_per_k2, 4, "ppm/K²"),
                signed(&of.offset_nt_per_k, 4),
                curvature(&of.offset_nt_per_k2, 5, "nT/K²")
            ),
        );
    };
    for (name, of) in [("sensor", &fit.sensor), ("electronics", &fit.electronics)] {
        if let Some(of) = of {
            part(name, of);
        }
    }
}

fn curvature(quantity: &Option<Quantity>, digits: usize, unit: &str) -> String {
    quantity.as_ref().map_or(String::new(), |quantity| format!(" and {} {unit}", signed(quantity, digits)))
}

fn cross_line(cross: &CrossFieldFit) -> String {
    let each = cross.offset.iter().map(|(name, size)| format!("offset {name} {}", signed(size, 3)));
    let scale =
        cross.sensitivity.iter().map(|(name, size)| format!("sensitivity {name} {}", signed(size, 3)));
    let all: Vec<String> = each.chain(scale).collect();
    let gain = cross.held_out.map_or(String::new(), |held| {
        format!("; held-out rms {:.3} → {:.3} nT", held.before_nt, held.after_nt)
    });
    format!("  50 000 nT across: {}{gain}", all.join(", "))
}

fn drift_line(drift: &OffsetDrift) -> String {
    let days = drift.dates.time_d.last().copied().unwrap_or(0.0);
    let trend = drift
        .trend_nt_per_year
        .as_ref()
        .map_or(String::new(), |trend| format!(", trend {} nT a year", signed(trend, 3)));
    format!(
        "  offset on {} dates in {days:.0} days: mean {} nT, rms {:.4} nT about it{trend}",
        drift.dates.time_d.len(),
        signed(&drift.mean_nt, 4),
        drift.rms_nt
    )
}

fn budget_line(budget: &ErrorBudget) -> String {
    let terms: Vec<String> =
        budget.terms.iter().take(3).map(|term| format!("{} {:.3}", term.term, term.std_nt)).collect();
    format!(
        "  at {:.0} nT: ± {:.3} nT (most from {}); worst case {:.3} nT",
        budget.field_nt,
        budget.standard_nt,
        terms.join(", "),
        budget.worst_case_nt
    )
}
