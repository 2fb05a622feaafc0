//! k and O of one sensor in a coil (NASA eq. 13 and 23 to 25, "Sensor Sensitivity and Nonlinearity").

use common::number::{bare, counted, p_value, plural, significant};
use common::uncertainty::{self, Block};
use common::{
    Axis, Budget, Code, Finding, Findings, PolynomialOrder, Quantity, SensitivityFit, SensitivityResiduals,
    TestResult, procedure,
};
use estimate::{normality, stats};
use physics::{FULL_NT, Kind, Parameter, Unit};

use crate::adopt;
use crate::conditions::Conditions;
use crate::departure::{self, Candidate, FOUND_BELOW};
use crate::fit::{self, Fit, Problem, Unknown};
use crate::readings::{Run, along, code_width, first_sensitivity, runs};
use crate::saturation;
use crate::shape::{Place, Subject};
use crate::{Error, Result};

/// Polynomials are tried up to this order.
const ORDERS: usize = 5;

/// Constants of a sensor as its coil shows them.
pub struct Constants {
    pub unit: Unit,
    pub sensitivity: f64,
    pub offset_nt: f64,
    pub covariance: [[f64; 2]; 2],
    /// Its type B part.
    pub common: [[f64; 2]; 2],
    /// k, O and the nonlinearity as they were estimated.
    pub block: Block,
    /// Derivatives of k and O by the parameters of temperature, part of their error; empty without.
    pub by_temperature: Vec<[f64; 2]>,
    /// Effects of the catalogue that were found, with their covariance.
    pub nonlinearity: Vec<(Kind, Quantity)>,
    pub largest_nt: f64,
    pub fit: SensitivityFit,
}

/// Fits the line, and what it leaves out where the readings say so; None without a recording.
pub fn calibrate(of: Subject<'_>, conditions: &Conditions) -> Result<Option<Constants>> {
    let Subject { document, references, sensor, .. } = of;
    let mut runs = runs(document, references, procedure::SENSOR_SENSITIVITY, sensor)?;
    if runs.is_empty() {
        return Ok(None);
    }
    let unit = runs[0].context.unit;
    let saturation = saturation::take_out(document, &mut runs, sensor)?;
    let code_nt = code_width(document, &runs[0]) * first_sensitivity(&runs);
    let shape = of.shape(code_nt);
    let all: Vec<usize> = (0..runs.len()).collect();
    let (effects, known) = conditions.effects_in(&runs);
    let mut knowns = fit::coils(document, &runs)?;
    knowns.extend(known);
    let constants = [Parameter::Sensitivity(sensor), Parameter::SensorOffset(sensor)];
    let unknowns = constants.map(|parameter| Unknown::Chain(parameter, all.clone())).to_vec();
    let allowed = fit::noise(&runs, &shape, Place::Coils)?;
    let candidates = candidates(&runs)?;
    let problem = Problem { runs: &runs, effects, unknowns, known: knowns, allowed: &allowed };
    let allowed = departure::noise_called_for(&problem, &candidates)?;
    let problem = Problem { allowed: &allowed, ..problem };
    let line = problem.solve()?;
    if line.linear.freedom < 2.0 {
        return Err(Error::Unanswerable(format!(
            "sensor {sensor}: {}; a straight line and its scatter need at least four",
            counted(line.linear.residuals.len(), "reading")
        )));
    }
    let mut extended = departure::extend(&problem, &candidates)?;
    let apart = agreement(&problem, &mut extended)?;
    let fit = &extended.fit;
    let orders = orders(&problem, &line)?;
    let pair = |of: &dyn Fn(usize, usize) -> f64| [[of(0, 0), of(0, 1)], [of(1, 0), of(1, 1)]];
    let key = sensitivity_key(unit);
    let budget = |i: usize| Budget { type_a: fit.type_a(i), type_b: fit.common[(i, i)].max(0.0).sqrt() };
    let total = fit.covariance(0, 0).sqrt();
    let effective = match fit.type_a(0) {
        a if a > 0.0 => fit.linear.freedom * (total / a).powi(4),
        _ => f64::INFINITY,
    };
    let mut noise = fit.noise.clone();
    noise.coverage_factor_95 = stats::coverage_factor(0.95, effective);
    let test = |(statistic, p_value): (f64, f64)| TestResult { statistic, p_value };
    let mut result = SensitivityFit {
        recordings: runs.iter().map(|run| run.context.recording.id.clone()).collect(),
        readings: fit.linear.residuals.len(),
        model: match extended.found.as_slice() {
            [] => "line".into(),
            found => format!("line with {}", found.join(" and ")),
        },
        uncertainty: [(key.to_string(), budget(0)), ("offset_nt".into(), budget(1))].into_iter().collect(),
        offset_nt: fit.quantity(1),
        order: order_in_words(&orders),
        orders,
        departures: extended.departures,
        rivals: extended.rivals,
        noise,
        normality: normality::anderson_darling(&fit.linear.whitened).map(test),
        runs: normality::runs(&fit.linear.whitened).map(test),
        saturation,
        residuals: residuals(&runs, &line, fit),
        ..SensitivityFit::default()
    };
    let places = extended.found.iter().enumerate();
    let bent: Vec<(Kind, usize)> =
        places.filter_map(|(at, name)| Some((Kind::named(name)?, 2 + at))).collect();
    let fields = runs.iter().flat_map(|run| run.rows.iter().map(|row| run.applied_nt(*row).abs()));
    let largest_nt = fields.fold(0.0, f64::max);
    result.findings = findings(&result, code_nt, conditions, &runs);
    result.findings.extend(apart);
    let by_temperature = |path: &String| {
        let moved = fit.by.iter().find(|(by, _)| by == path).map(|(_, moved)| moved);
        moved.map(|moved| [moved[0], moved[1]])
    };
    Ok(Some(Constants {
        unit,
        sensitivity: fit.values[0],
        offset_nt: fit.values[1],
        covariance: pair(&|i, j| fit.covariance(i, j)),
        common: pair(&|i, j| fit.common[(i, j)]),
        by_temperature: conditions.paths.iter().filter_map(by_temperature).collect(),
        block: block(sensor, unit, fit, &bent),
        nonlinearity: bent.iter().map(|(kind, at)| (*kind, fit.quantity(*at))).collect(),
        largest_nt,
        fit: result,
    }))
}

/// k, O and the nonlinearity, by the scatter of the readings and by what the fit rests on.
fn block(sensor: Axis, unit: Unit, fit: &Fit, bent: &[(Kind, usize)]) -> Block {
    let effects = bent.iter().map(|(kind, _)| adopt::path(*kind, sensor, kind.parameters()[0].name));
    let constants = [uncertainty::sensitivity(sensor, unit.suffix()), uncertainty::sensor_offset(sensor)];
    let parameters: Vec<String> = constants.into_iter().chain(effects).collect();
    let places: Vec<usize> = [0, 1].into_iter().chain(bent.iter().map(|(_, at)| *at)).collect();
    Block {
        name: format!("sensor {sensor}: scatter in the coil"),
        degrees_of_freedom: fit.linear.freedom,
        covariance: fit.scatter_of(&places),
        by: fit.by(&places),
        parameters,
    }
}

/// Whether several recordings agree on k and O; where they do not, uncertainties rest on their differences.
fn agreement(problem: &Problem<'_, '_>, extended: &mut departure::Extended) -> Result<Option<Finding>> {
    let count = problem.runs.len();
    if count < 2 {
        return Ok(None);
    }
    let sensor = problem.runs[0].sensor;
    let one = |parameter: Parameter| (0..count).map(move |run| Unknown::Chain(parameter, vec![run]));
    let own = one(Parameter::Sensitivity(sensor)).chain(one(Parameter::SensorOffset(sensor))).collect();
    let single = problem.allowed.likeliest(&extended.fit.linear);
    let squares = |unknowns: Vec<Unknown>| -> Result<(f64, f64)> {
        let fit = Problem { allowed: &single, ..problem.with(unknowns) }.solve()?;
        Ok((fit.sum_of_squares(), fit.linear.freedom))
    };
    let (shared, apart) = (squares(problem.unknowns.clone())?, squares(own)?);
    let (above, below) = (shared.1 - apart.1, apart.1);
    let f = (shared.0 - apart.0).max(0.0) / above / (apart.0 / below);
    let p = stats::f_p(f, above, below);
    if p >= FOUND_BELOW {
        return Ok(None);
    }
    extended.fit.widened *= f;
    Ok(Some(Code::RecordingsDiffer.said(format!(
        "the recordings disagree on k and O ({}); the uncertainties are based on their differences",
        p_value(p)
    ))))
}

pub fn sensitivity_key(unit: Unit) -> &'static str {
    match unit {
        Unit::Volt => "sensitivity_nt_per_v",
        Unit::Nanotesla => "sensitivity_nt_per_nt",
    }
}

/// +½ on the way up, −½ on the way down, by row.
fn branches(field: &[f64]) -> Vec<f64> {
    let mut way = 0.0;
    let mut branches: Vec<f64> = std::iter::once(0.0)
        .chain(field.windows(2).map(|pair| {
            if pair[0] != pair[1] {
                way = if pair[1] > pair[0] { 0.5 } else { -0.5 };
            }
            way
        }))
        .collect();
    // The first readings belong to the way that follows.
    let first = branches.iter().copied().find(|way| *way != 0.0).unwrap_or(0.0);
    branches.iter_mut().take_while(|way| **way == 0.0).for_each(|way| *way = first);
    branches
}

fn candidates(runs: &[Run<'_>]) -> Result<Vec<Candidate>> {
    let each = |of: &dyn Fn(&Run<'_>) -> Vec<f64>| runs.iter().map(of).collect();
    let hours = |run: &Run<'_>| {
        let time = run.context.recording.column("time_s").unwrap_or_default();
        let middle = run.rows.iter().filter_map(|row| time.get(*row)).sum::<f64>() / run.rows.len() as f64;
        time.iter().map(|t| (t - middle) / 3600.0).collect()
    };
    let mut all = vec![
        Candidate::effect(Kind::QuadraticNonlinearity, 0, runs)?,
        Candidate::effect(Kind::CubicNonlinearity, 0, runs)?,
        Candidate {
            name: "hysteresis_between_branches",
            parameter: "up_less_down_nt",
            column: each(&|run| branches(&along(run))),
        },
        Candidate {
            name: "sensitivity_between_signs",
            parameter: "negative_less_positive_nt",
            column: each(&|run| along(run).iter().map(|b| b.min(0.0) / FULL_NT).collect()),
        },
    ];
    if runs.iter().all(|run| run.times().is_some()) {
        all.push(Candidate { name: "offset_drift", parameter: "rate_nt_per_h", column: each(&hours) });
    }
    Ok(all)
}

/// Polynomials from the line up, the last term of each tested beside the lower ones.
fn orders(problem: &Problem<'_, '_>, line: &Fit) -> Result<Vec<PolynomialOrder>> {
    let tested = |order: usize, fit: &Fit, last: usize| PolynomialOrder {
        order,
        rms_nt: fit.noise.rms_nt,
        p_value: stats::two_sided_p(fit.values[last] / fit.type_a(last), fit.linear.freedom),
    };
    let mut orders = vec![tested(1, line, 0)];
    let mut unknowns = problem.unknowns.clone();
    for order in 2..=ORDERS {
        let power = |run: &Run<'_>| along(run).iter().map(|b| (b / FULL_NT).powi(order as i32)).collect();
        unknowns.push(Unknown::Column(problem.runs.iter().map(power).collect()));
        let fit = problem.with(unknowns.clone()).solve()?;
        if fit.linear.rank < unknowns.len() || fit.linear.freedom < 2.0 {
            break;
        }
        orders.push(tested(order, &fit, order));
    }
    Ok(orders)
}

/// The highest order whose last term is significant among all that were tried.
fn chosen(orders: &[PolynomialOrder]) -> Option<&PolynomialOrder> {
    let tried = orders.len() as f64 - 1.0;
    orders.iter().rev().find(|order| order.order > 1 && order.p_value * tried < FOUND_BELOW)
}

fn order_in_words(orders: &[PolynomialOrder]) -> String {
    let least = orders.iter().skip(1).map(|order| order.p_value).fold(1.0, f64::min);
    if let Some(PolynomialOrder { order, p_value: p, .. }) = chosen(orders) {
        return format!("order {order}: its highest term is significant ({}), no higher one is", p_value(*p));
    }
    let (most, p) = (orders.len(), p_value(least));
    format!("order 1: no higher term up to order {most} is significant (smallest {p})")
}

fn residuals(runs: &[Run<'_>], line: &Fit, fit: &Fit) -> SensitivityResiduals {
    let mut columns = SensitivityResiduals::default();
    for (number, run) in runs.iter().enumerate() {
        let along = along(run);
        for row in &run.rows {
            columns.recording.push(number);
            columns.field_nt.push(along[*row]);
            columns.reading.push(run.reading[*row]);
        }
    }
    columns.deviation_nt = line.linear.residuals.clone();
    columns.residual_nt = fit.linear.residuals.clone();
    columns
}

fn findings(fit: &SensitivityFit, code_nt: f64, conditions: &Conditions, runs: &[Run<'_>]) -> Findings {
    let mut findings = Findings::default();
    for departure in fit.departures.iter().filter(|departure| departure.found) {
        let size: Vec<String> =
            departure.parameter.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        findings.push(Code::Nonlinear.said(format!(
            "not a straight line: {} (unadjusted {}, adjusted {}); fitted jointly with k and O",
            departure.departure,
            size.join(", "),
            p_value(departure.p_adjusted)
        )));
    }
    if !fit.rivals.is_empty() {
        findings.push(Code::Ambiguous.said(format!(
            "{} would explain the readings about as well; to distinguish them, sweep down after the sweep up, or apply the fields in random order",
            fit.rivals.join(" or ")
        )));
    }
    if let Some(order) = chosen(&fit.orders).filter(|order| order.order > 3) {
        findings.push(Code::HigherOrderTerm.about(order.order).said(format!(
            "a term of order {} is significant ({}) but neither in the fit nor described by an effect of the catalogue; see the deviations",
            order.order,
            p_value(order.p_value)
        )));
    }
    if let Some(saturation) = &fit.saturation {
        let side = |side: usize| {
            let (nt, reading) = (saturation.fields_nt[side]?, saturation.readings[side]?);
            Some(format!("{} {} nT at {}", ["below", "above"][side], significant(nt, 4), bare(reading)))
        };
        let sides: Vec<String> = [0, 1].into_iter().filter_map(side).collect();
        let (sides, readings) = (sides.join(" and "), counted(saturation.count, "reading"));
        let are = plural(saturation.count, "is", "are");
        let words = format!("the output is saturated {sides}; {readings} {are} left out");
        findings.push(Code::Saturated.said(words));
    }
    if let Some(normality) = fit.normality.filter(|test| test.p_value < FOUND_BELOW) {
        let reason = if code_nt > 2.0 * fit.noise.rms_nt {
            format!(", as expected of quantisation steps of {} nT make them", significant(code_nt, 3))
        } else {
            String::new()
        };
        findings.push(Code::ResidualsNotNormal.said(format!(
            "the residuals are not normal (Anderson-Darling {}){reason}",
            p_value(normality.p_value)
        )));
    }
    if let Some(runs) = fit.runs.filter(|test| test.p_value < FOUND_BELOW) {
        let words = format!("the residuals are serially correlated (runs test, {})", p_value(runs.p_value));
        findings.push(Code::SeriallyCorrelated.said(words));
    }
    if let Some(factor) = fit.noise.variance_factor
        && stats::chi_squared_p(factor * fit.noise.degrees_of_freedom, fit.noise.degrees_of_freedom)
            < FOUND_BELOW
    {
        findings.push(Code::ExcessScatter.said(format!(
            "the residuals scatter {} times as much as the sensor's own noise: noise of the applied field is included",
            significant(factor.sqrt(), 3)
        )));
    }
    findings.extend(conditions.not_recorded(runs));
    findings
}
