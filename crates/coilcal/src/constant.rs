//! k and B0 of one coil.

use common::covariance;
use common::number::{counted, p_value};
use common::uncertainty::{self, Block, By};
use common::{Budget, CoilCalibration, CoilFit, CoilResiduals, Departure, Document, Quantity, Uncertainty};
use estimate::linear::LinearFit;
use estimate::stats;
use faer::Mat;

use crate::Error;
use crate::departures::{self, DepartureKind, FOUND_BELOW};
use crate::levels::{Level, levels, mean, within};
use crate::readings::{Reading, Readings};
use crate::scatter::{lack_of_fit, relative_std, scatter};

/// Below this probability the lack of fit is reported.
const TOLD_BELOW: f64 = 0.01;
/// A departure whose χ² is within this of the best one's is as good: 99 % of one degree of freedom.
const RIVAL_WITHIN: f64 = 6.63;
/// Departures that are fitted together at most.
const MOST_DEPARTURES: usize = 2;

/// Fits the line, and what it leaves out where the readings say so.
pub fn calibrate(
    document: &Document,
    coil: &Readings,
    joint: &mut Uncertainty,
) -> Result<CoilCalibration, Error> {
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
    let line = departures::fit(readings, &[], &relative_std)?;
    let (mut kinds, mut looked) = (Vec::new(), departures::look(readings, &levels, &relative_std, declared)?);
    let (mut fit, mut rivals) = (line, Vec::new());
    // One departure after the other, the most significant first, as long as the line with it leaves another
    // one.
    while kinds.len() < MOST_DEPARTURES {
        let candidates = candidates((readings, &levels, &relative_std), declared, (&kinds, &fit), &looked)?;
        let Some(best) = candidates.first() else { break };
        if kinds.is_empty() {
            let close =
                candidates[1..].iter().filter(|other| best.gain - other.gain < RIVAL_WITHIN * best.variance);
            rivals = close.map(|other| other.kind.name.to_string()).collect();
        }
        kinds.push(best.kind);
        fit = departures::fit(readings, &kinds, &relative_std)?;
    }
    for (kind, departure) in &mut looked {
        departure.found = kinds.contains(kind);
    }
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
            by: measured_with(document, coil, k),
        })
        .map_err(Error::Unanswerable)?;
    let std = paths.each_ref().map(|path| joint.std(path));
    let type_b = |i: usize| (std[1 - i].powi(2) - type_a(i).powi(2)).max(0.0).sqrt();
    let coverage = paths.each_ref().map(|path| stats::coverage_factor(0.95, joint.degrees_of_freedom(path)));
    let (_, repeats) = within(&levels, |_| 0.0);
    let (pure, _) = within(&levels, |member| fit.residuals[member]);
    let order = ["constant_nt_per_a", "offset_nt"].map(String::from);
    let mut result = CoilFit {
        recordings: coil.recordings.clone(),
        readings: readings.len(),
        levels: levels.len(),
        model: match kinds.as_slice() {
            [] => "line".into(),
            kinds => {
                format!("line with {}", kinds.iter().map(|kind| kind.name).collect::<Vec<_>>().join(" and "))
            }
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
        departures: looked.into_iter().map(|(_, departure)| departure).collect(),
        residuals: residuals(coil, &levels, &fit, |member| scatter.std_nt * relative_std[member]),
        ..CoilFit::default()
    };
    result.findings = findings(coil, &kinds, &result);
    Ok(CoilCalibration {
        constant_nt_per_a: Some(Quantity::new(k, std[0]).covered_by(coverage[0])),
        offset_nt: Some(Quantity::new(b0, std[1]).covered_by(coverage[1])),
        covariance: Some(covariance::rows(&joint.covariance(&paths))),
        covariance_order: Some(order.to_vec()),
        constant: Some(Box::new(result)),
        ..CoilCalibration::default()
    })
}

/// A departure beside those that are fitted already.
struct Candidate {
    kind: &'static DepartureKind,
    /// Reduction of the sum of squares, nT².
    gain: f64,
    /// Variance of a reading's residual beside it, nT².
    variance: f64,
}

/// The departures that the readings show beside those that are fitted already, the clearest first.
fn candidates(
    (readings, levels, relative_std): (&[Reading], &[Level], &[f64]),
    declared: Option<f64>,
    (kinds, fit): (&[&DepartureKind], &LinearFit),
    looked: &[(&'static DepartureKind, Departure)],
) -> Result<Vec<Candidate>, Error> {
    let mut found = Vec::new();
    for (kind, _) in looked.iter().filter(|(kind, _)| !kinds.contains(kind)) {
        let wider = departures::fit(readings, &[kinds, &[*kind]].concat(), relative_std)?;
        let last = kinds.len() + 2;
        if wider.rank <= last || wider.freedom < 1.0 || (kind.adds && wider.coefficients[last] < 0.0) {
            continue;
        }
        let scatter = scatter(levels, &wider, declared);
        if scatter.freedom < 1.0 {
            continue;
        }
        let (gain, variance) = ((fit.sum_of_squares - wider.sum_of_squares).max(0.0), scatter.std_nt.powi(2));
        let p_value = stats::two_sided_p((gain / variance).sqrt(), scatter.freedom);
        if p_value * (looked.len() as f64) < FOUND_BELOW {
            found.push(Candidate { kind, gain, variance });
        }
    }
    found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    Ok(found)
}

/// How k and B0 move with resistor and voltmeter, the same at all points: against what these do to a
/// calculated field.
fn measured_with(document: &Document, coil: &Readings, k: f64) -> By {
    if !coil.volts {
        return Vec::new();
    }
    let current = uncertainty::of_current(document, coil.coil, k).into_iter();
    current.map(|(path, like)| (path, like.iter().map(|change| -change).collect())).collect()
}

fn residuals(
    coil: &Readings,
    levels: &[Level],
    fit: &LinearFit,
    std_nt: impl Fn(usize) -> f64,
) -> CoilResiduals {
    let mut columns = CoilResiduals::default();
    for level in levels {
        columns.drive_a.push(mean(level, |member| coil.readings[member].current_a));
        columns.field_nt.push(mean(level, |member| coil.readings[member].field_nt));
        columns.residual_nt.push(mean(level, |member| fit.residuals[member]));
        columns.std_nt.push(std_nt(level.members[0]) / (level.members.len() as f64).sqrt());
        columns.readings.push(level.members.len());
    }
    columns
}

fn findings(coil: &Readings, kinds: &[&DepartureKind], fit: &CoilFit) -> Vec<String> {
    let mut findings = Vec::new();
    for departure in fit.departures.iter().filter(|departure| departure.found) {
        let size: Vec<String> =
            departure.parameter.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        findings.push(format!(
            "not a straight line: {} (unadjusted {}, adjusted {}); fitted jointly with constant and offset",
            departure.departure,
            size.join(", "),
            p_value(departure.p_adjusted)
        ));
    }
    if !fit.rivals.is_empty() {
        findings.push(format!(
            "{} would explain the readings about as well; to distinguish them, record fields closer to zero, or the levels in another order",
            fit.rivals.join(" or ")
        ));
    }
    if let Some(lack) = fit.lack_of_fit.filter(|lack| lack.p_value < TOLD_BELOW) {
        let left = if kinds.is_empty() {
            "no effect in the search explains it"
        } else {
            "the fitted effects explain only part of it"
        };
        findings.push(format!(
            "the levels scatter more than repeated readings (lack of fit, {}) and {left}; the uncertainties are based on the {}",
            p_value(lack.p_value),
            fit.noise_source
        ));
    }
    let signs = [1.0, -1.0].map(|sign| coil.readings.iter().any(|reading| reading.current_a * sign > 0.0));
    if signs.contains(&false) {
        findings
            .push("the current was recorded in one direction only; the offset is an extrapolation".into());
    }
    findings
}
