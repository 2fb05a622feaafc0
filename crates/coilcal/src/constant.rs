//! k and B0 of one coil.

use common::covariance;
use common::number::{counted, p_value};
use common::uncertainty::{self, Block};
use common::{
    Budget, Code, CoilCalibration, CoilFit, CoilResiduals, Document, Findings, Quantity, Uncertainty,
};
use estimate::stats;
use faer::Mat;

use crate::departures::{Found, Run};
use crate::readings::Readings;
use crate::scatter::{lack_of_fit, levels, mean, relative_std, scatter, within};
use crate::{Error, Result};

/// Below this probability the lack of fit is reported.
const TOLD_BELOW: f64 = 0.01;

/// Fits the line, and what it leaves out where the readings say so.
pub fn calibrate(document: &Document, coil: &Readings, joint: &mut Uncertainty) -> Result<CoilCalibration> {
    let readings = &coil.readings;
    let levels = levels(readings);
    if levels.len() < 3 {
        return Err(Error::Unanswerable(format!(
            "coil {}: {} recorded; a straight line and its lack-of-fit test need at least three, preferably on both sides of zero",
            coil.coil,
            counted(levels.len(), "different drive")
        )));
    }
    let declared = document.facility.as_ref().and_then(|facility| facility.reference_std_nt);
    let relative_std = relative_std(readings, &levels);
    let weighted = relative_std.iter().any(|std| *std != 1.0);
    let run = Run { readings, levels: &levels, relative_std: &relative_std, declared };
    let Found { fit, names, departures, rivals } = run.search()?;
    let lack_of_fit = lack_of_fit(&levels, &fit);
    let scatter = scatter(&levels, &fit, declared);
    let variance = scatter.std_nt.powi(2);
    let (b0, k) = (fit.coefficients[0], fit.coefficients[1]);
    let type_a = |i: usize| (fit.covariance[(i, i)] * variance).sqrt();
    let paths = [uncertainty::coil_constant(coil.coil), uncertainty::coil_offset(coil.coil)];
    joint
        .put(Block {
            name: format!("coil {}: scatter of the readings", coil.coil),
            degrees_of_freedom: scatter.freedom,
            parameters: paths.to_vec(),
            covariance: Mat::from_fn(2, 2, |i, j| fit.covariance[(1 - i, 1 - j)] * variance),
            // Resistor and voltmeter, the same at all points, against what they do to a calculated field.
            by: uncertainty::of_current(document, coil.coil, k)
                .into_iter()
                .filter(|_| coil.volts)
                .map(|(path, like)| (path, like.iter().map(|change| -change).collect()))
                .collect(),
        })
        .map_err(Error::Unanswerable)?;
    let std = paths.each_ref().map(|path| joint.std(path));
    let type_b = |i: usize| (std[1 - i].powi(2) - type_a(i).powi(2)).max(0.0).sqrt();
    let coverage = paths.each_ref().map(|path| stats::coverage_factor(0.95, joint.degrees_of_freedom(path)));
    let (_, repeats) = within(&levels, |_| 0.0);
    let (pure, _) = within(&levels, |member| fit.residuals[member]);
    let order = ["constant_nt_per_a", "offset_nt"].map(String::from);
    let mut residuals = CoilResiduals::default();
    for level in &levels {
        residuals.drive_a.push(mean(level, |member| readings[member].current_a));
        residuals.field_nt.push(mean(level, |member| readings[member].field_nt));
        residuals.residual_nt.push(mean(level, |member| fit.residuals[member]));
        residuals.std_nt.push(scatter.std_nt * relative_std[level[0]] / (level.len() as f64).sqrt());
        residuals.readings.push(level.len());
    }
    let mut result = CoilFit {
        recordings: coil.recordings.clone(),
        readings: readings.len(),
        levels: levels.len(),
        model: match names.as_slice() {
            [] => "line".into(),
            names => format!("line with {}", names.join(" and ")),
        },
        uncertainty: order
            .iter()
            .zip([1, 0])
            .map(|(key, i)| (key.clone(), Budget { type_a: type_a(i), type_b: type_b(i) }))
            .collect(),
        rms_nt: (fit.residuals.iter().map(|r| r * r).sum::<f64>() / readings.len() as f64).sqrt(),
        pure_error_nt: (repeats > 0.0).then(|| (pure / repeats).sqrt()),
        noise_nt: scatter.std_nt,
        noise_source: if weighted {
            format!("{}, weighted by level", scatter.source)
        } else {
            scatter.source.into()
        },
        degrees_of_freedom: scatter.freedom,
        coverage_factor_95: coverage[0],
        lack_of_fit,
        offset_p: stats::two_sided_p(b0 / std[1], f64::INFINITY),
        rivals,
        departures,
        residuals,
        ..CoilFit::default()
    };
    result.findings = findings(coil, &result);
    Ok(CoilCalibration {
        constant_nt_per_a: Some(Quantity::new(k, std[0]).covered_by(coverage[0])),
        offset_nt: Some(Quantity::new(b0, std[1]).covered_by(coverage[1])),
        covariance: Some(covariance::rows(&joint.covariance(&paths))),
        covariance_order: Some(order.to_vec()),
        constant: Some(Box::new(result)),
        ..CoilCalibration::default()
    })
}

fn findings(coil: &Readings, fit: &CoilFit) -> Findings {
    let mut findings = Findings::default();
    for departure in fit.departures.iter().filter(|departure| departure.found) {
        let size: Vec<String> =
            departure.parameter.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        findings.push(Code::Nonlinear.said(format!(
            "not a straight line: {} (unadjusted {}, adjusted {}); fitted jointly with constant and offset",
            departure.departure,
            size.join(", "),
            p_value(departure.p_adjusted)
        )));
    }
    if !fit.rivals.is_empty() {
        findings.push(Code::Ambiguous.said(format!(
            "{} would explain the readings about as well; to distinguish them, record fields closer to zero, or the levels in another order",
            fit.rivals.join(" or ")
        )));
    }
    if let Some(lack) = fit.lack_of_fit.filter(|lack| lack.p_value < TOLD_BELOW) {
        let left = if fit.departures.iter().any(|departure| departure.found) {
            "the fitted effects explain only part of it"
        } else {
            "no effect in the search explains it"
        };
        findings.push(Code::LackOfFit.said(format!(
            "the levels scatter more than repeated readings (lack of fit, {}) and {left}; the uncertainties are based on the {}",
            p_value(lack.p_value),
            fit.noise_source
        )));
    }
    let signs = [1.0, -1.0].map(|sign| coil.readings.iter().any(|reading| reading.current_a * sign > 0.0));
    if signs.contains(&false) {
        let words = "the current was recorded in one direction only; the offset is an extrapolation";
        findings.push(Code::OneDirectionOnly.said(words));
    }
    findings
}
