//! The result in a few lines for people.

use common::number::{bare, counted, figures, p_value, significant, uncertain};
use common::{
    Axis, CommonExtremum, CrossFieldFit, Document, ErrorBudget, OffsetDrift, PerAxis, Quantity,
    SensorCalibration, SensorNoise, TemperatureOfPart,
};

/// What was found of each sensor, with ± and units, and what looks wrong.
pub fn summary(document: &Document) -> String {
    let calibration = document.calibration.as_ref();
    let sensors = calibration.and_then(|calibration| calibration.sensors.as_ref());
    let mut lines: Vec<String> =
        sensors.into_iter().flat_map(PerAxis::iter).flat_map(|(axis, sensor)| of(axis, sensor)).collect();
    for extremum in calibration.iter().flat_map(|calibration| &calibration.common_extrema) {
        let CommonExtremum { quantity, part, temperature_c: at, .. } = extremum;
        let p = p_value(extremum.p_value);
        lines.push(format!(
            "{quantity} of all sensors is stationary at {at} degC of the {part} ({p}): a good operating temperature"
        ));
    }
    if !lines.is_empty() {
        lines.push(
            "  ± is one standard uncertainty; multiply by coverage_factor_95 in the document for a 95 % interval"
                .into(),
        );
    }
    lines.into_iter().map(|line| line + "\n").collect()
}

fn of(axis: Axis, sensor: &SensorCalibration) -> Vec<String> {
    let volts = sensor.sensitivity_nt_per_v.as_ref().map(|k| format!(" {k} nT/V"));
    let k = volts.or(sensor.sensitivity_nt_per_nt.as_ref().map(|k| format!(" {k} nT/nT")));
    let offset = sensor.offset_nt.as_ref().map(|offset| format!(", offset {offset:+} nT"));
    let fit = sensor.sensitivity.as_ref().map(|fit| {
        let (readings, rms) = (counted(fit.readings, "reading"), significant(fit.noise.rms_nt, 3));
        format!("; {}, {readings}, rms {rms} nT", fit.model)
    });
    let head = [k, offset, fit].into_iter().flatten().collect::<String>();
    let mut lines = vec![format!("sensorcal: sensor {axis}:{head}")];
    let mut findings: Vec<&String> = sensor.sensitivity.iter().flat_map(|fit| fit.findings.iter()).collect();
    if let Some(reversal) = &sensor.reversal {
        let pairs: usize = reversal.recordings.iter().map(|one| one.pairs.row.len()).sum();
        let turn = &reversal.imperfect_turn;
        lines.push(format!(
            "  reversals: offset {:+} nT from {}; an error of {}° in the turn would change it by at most {} nT",
            reversal.offset_nt,
            counted(pairs, "pair"),
            bare(turn.angle_deg),
            significant(turn.bound_nt, 2)
        ));
        findings.extend(reversal.findings.iter());
    }
    if let Some(noise) = &sensor.noise {
        lines.push(noise_line(noise));
        findings.extend(noise.findings.iter());
    }
    if let Some(temperature) = &sensor.temperature {
        let parts = [("sensor", &temperature.sensor), ("electronics", &temperature.electronics)];
        lines.extend(parts.iter().filter_map(|(name, of)| Some(temperature_line(name, of.as_ref()?))));
        findings.extend(temperature.findings.iter());
    }
    if let Some(cross) = &sensor.cross_field {
        lines.push(cross_line(cross));
        findings.extend(cross.findings.iter());
    }
    if let Some(drift) = &sensor.drift {
        lines.push(drift_line(drift));
        findings.extend(drift.findings.iter());
    }
    if let Some(budget) = sensor.budget.iter().rev().find(|budget| budget.warmer_k == 0.0) {
        lines.push(budget_line(budget));
    }
    lines.extend(findings.into_iter().map(|finding| format!("    {finding}")));
    lines
}

fn noise_line(noise: &SensorNoise) -> String {
    let flicker = match noise.flicker_below_nt2_per_hz {
        Some(bound) => format!("flicker below {} pT/√Hz at 1 Hz", significant(1e3 * bound.sqrt(), 2)),
        None => {
            let density = &noise.density_at_1hz_nt_per_sqrt_hz;
            let density = uncertain(1e3 * density.value(), 1e3 * density.std().unwrap_or(0.0));
            format!("{density} pT/√Hz at 1 Hz, as 1/f^α with α = {}", noise.flicker_exponent)
        }
    };
    let white = match noise.white_below_nt {
        Some(bound) => format!("white below {} nT a reading", significant(bound, 2)),
        None => format!("white {} nT a reading", noise.white_rms_nt),
    };
    let band = noise.bands.first().map_or(String::new(), |band| {
        let [low, high] = band.band_hz.map(|hz| significant(hz, 2));
        format!("; flicker rms {} nT from {low} to {high} Hz", band.flicker_rms_nt)
    });
    format!("  noise: {flicker}; {white}{band}")
}

fn temperature_line(name: &str, of: &TemperatureOfPart) -> String {
    let curvature = |quantity: &Option<Quantity>, unit: &str| {
        quantity.as_ref().map_or(String::new(), |quantity| format!(" and {quantity:+} {unit}"))
    };
    format!(
        "  {name} from {} to {} degC: the measured field changes by {:+} ppm/K{}, and by {:+} nT/K{}",
        significant(of.range_c[0], 3),
        significant(of.range_c[1], 3),
        of.sensitivity_ppm_per_k,
        curvature(&of.sensitivity_ppm_per_k2, "ppm/K²"),
        of.offset_nt_per_k,
        curvature(&of.offset_nt_per_k2, "nT/K²")
    )
}

fn cross_line(cross: &CrossFieldFit) -> String {
    let each = cross.offset.iter().map(|(name, size)| format!("offset {name} {size:+}"));
    let scale = cross.sensitivity.iter().map(|(name, size)| format!("sensitivity {name} {size:+}"));
    let all: Vec<String> = each.chain(scale).collect();
    let gain = cross.held_out.map_or(String::new(), |held| {
        let first = held.first_pass_nt.unwrap_or(held.after_nt);
        let each = [Some(held.before_nt), Some(first), held.second_pass_nt];
        let all: Vec<String> = each.into_iter().flatten().map(|nt| significant(nt, 3)).collect();
        format!("; held-out rms {} nT", all.join(" → "))
    });
    format!("  50000 nT transverse: {}{gain}", all.join(", "))
}

fn drift_line(drift: &OffsetDrift) -> String {
    let days = drift.dates.time_d.last().copied().unwrap_or(0.0);
    let trend = drift
        .trend_nt_per_year
        .as_ref()
        .map_or(String::new(), |trend| format!(", trend {trend:+} nT a year"));
    let (dates, days) = (counted(drift.dates.time_d.len(), "date"), significant(days, 4));
    let (mean, rms) = (&drift.mean_nt, significant(drift.rms_nt, 3));
    format!("  offset on {dates} in {days} days: mean {mean:+} nT, rms {rms} nT about it{trend}")
}

fn budget_line(budget: &ErrorBudget) -> String {
    let largest = budget.terms.iter().take(3);
    let terms: Vec<String> =
        largest.map(|term| format!("{} {}", term.term, significant(term.std_nt, 2))).collect();
    let (field, standard, terms) = (bare(budget.field_nt), figures(budget.standard_nt, 2), terms.join(", "));
    let worst = significant(budget.worst_case_nt, 2);
    format!("  at {field} nT: ± {standard} nT (mainly {terms}); worst case {worst} nT")
}
