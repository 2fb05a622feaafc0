//! What fields across a sensor do to it (the report's "Orthogonal Field Effects on Sensitivity and Offset").
//!
//! A sensor that is not quite along its coil reads a share of the field across, which is odd in that field
//! and does not depend on the field along: this belongs to the axes. The sensor's own is even in the field
//! across (the catalogue's `cross_field`) or goes with the field along (`cross_field_sensitivity`).

use common::covariance::rows;
use common::number::p_value;
use common::uncertainty::Block;
use common::{Axis, Code, CrossFieldFit, CrossFieldLevels, FTest, FitNoise, Quantity, TestResult, procedure};
use estimate::stats;
use faer::{Col, Mat};
use physics::{FULL_NT, Kind};

use crate::adopt;
use crate::conditions::Conditions;
use crate::departure::{self, Candidate, FOUND_BELOW};
use crate::effects::{self, Sought, sought};
use crate::fit::{self, Fit, Problem, Unknown};
use crate::leaning::{ACROSS, Across};
use crate::levels;
use crate::passes::{self, LeftOut};
use crate::readings::{Run, code_width, runs};
use crate::shape::{Place, Shape, Subject};
use crate::sides::Sides;
use crate::sizes::Sized;
use crate::{Error, Result};

/// A level has so many readings at least.
const LEVEL: usize = 3;
/// Fields across that are levels, and not a field that moves on its way, at most.
const MOST_LEVELS: usize = 100;

pub struct AcrossFindings {
    pub block: Block,
    /// Standard deviation of a parameter that was not seen, for each of [`effects::KINDS`], nT.
    pub likely: [f64; 2],
    /// Readings that were left out of a fit, one after the other.
    pub left_out: Vec<LeftOut>,
}

/// Coefficients of a sensor; None without a recording.
pub fn coefficients(
    of: Subject<'_>,
    conditions: &Conditions,
    sides: &Sides,
) -> Result<Option<(CrossFieldFit, AcrossFindings)>> {
    let Subject { document, references, sensor, .. } = of;
    let runs = runs(document, references, procedure::CROSS_FIELD, sensor)?;
    if runs.is_empty() {
        return Ok(None);
    }
    let across = Across::of(&runs)?;
    let mut found = CrossFieldFit {
        recordings: runs.iter().map(|run| run.context.recording.id.clone()).collect(),
        ..CrossFieldFit::default()
    };
    if let Some(run) = runs.iter().find(|run| !run.oriented) {
        let found = "no orientation of the block";
        let expected =
            "`orientation` or `theodolite`, which give the directions of the transverse fields at the sensor";
        return Err(Error::document(format!("{}.conditions", run.path), found, expected));
    }
    let shape = of.shape(code_width(document, &runs[0]) * runs[0].basic.sensors[sensor.index()].sensitivity);
    let (effects, known) = conditions.effects_in(&runs);
    let mut knowns = fit::coils(document, &runs)?;
    knowns.extend(known);
    let mut unknowns = across.unknowns(&runs);
    unknowns.extend(levels::polynomial(&runs));
    let place = if across.held.is_empty() { Place::Coils } else { Place::Levels };
    let allowed = fit::noise(&runs, &shape, place)?;
    let base = Problem { runs: &runs, effects, unknowns, known: knowns, allowed: &allowed };
    let without = base.solve()?;
    let directions = sides.solve(&across.cosines(&runs, &without))?;
    let sided = effects::turned(&runs, &directions.eta, |_| 0.0);
    let (sought, unseen) = sought(&sided, &without.design)?;
    let mut unknowns = base.unknowns.clone();
    unknowns.extend(sought.iter().map(|one| Unknown::Column(one.column.clone())));
    let problem = Problem { unknowns, ..base };
    let candidates = [squared(&runs, &across.coils)];
    let allowed = departure::noise_called_for(&problem, &candidates)?;
    let problem = Problem { allowed: &allowed, ..problem };
    let same = departure::extend(&problem, &candidates)?;
    let sized = Sized::of(allowed.clone(), &same.fit, &runs, (&shape, place))?;
    let problem = Problem { allowed: &sized.allowed, ..problem };
    let extended = departure::extend(&problem, &candidates)?;
    let fit = &extended.fit;
    let first = without.values.len();
    let places: Vec<usize> = (first..first + sought.len()).collect();
    let likely = effects::likely(&sought, fit, first);
    let errors = effects::unknown(&sided, &directions, (&sought, &unseen), (fit, first), likely)?;
    // From scatter, and from errors that add columns to the readings.
    let mut own = fit.scatter_of(&places);
    for error in &errors {
        let shift = problem.taken_up(&fit.design, &fit.linear, error)?;
        let shift = Col::from_fn(places.len(), |at| shift[places[at]]);
        own += &shift * shift.transpose();
    }
    for (at, one) in sought.iter().enumerate() {
        let variance = own[(at, at)] + fit.common[(first + at, first + at)];
        let quantity = Quantity::new(fit.values[first + at], variance.sqrt());
        let (name, group) = match one.kind {
            Kind::CrossField => ("offset", &mut found.offset),
            _ => ("sensitivity", &mut found.sensitivity),
        };
        group.insert(one.name().into(), quantity);
        found.covariance_order.push(format!("{name}.{}", one.name()));
    }
    let count = places.len();
    found.covariance = rows(&(&own + fit.common.submatrix(first, first, count, count)));
    let (freedom, factor) = sized.freedom(fit, &places)?;
    let parameters = sought.iter().map(|one| adopt::path(one.kind, sensor, one.name()));
    let block = Block {
        name: format!("sensor {sensor}: scatter with transverse fields"),
        degrees_of_freedom: freedom,
        parameters: parameters.collect(),
        covariance: own,
        by: fit.by(&places),
    };
    found.departures = extended.departures;
    found.noise = FitNoise { degrees_of_freedom: freedom, coverage_factor_95: factor, ..fit.noise.clone() };
    found.significance = Some(significance(fit, &places, freedom));
    found.misalignments = across.named(&runs, fit);
    let lean = problem.with(problem.unknowns[..first].to_vec());
    levels_of(&lean, &across, &shape, &mut found)?;
    let (held_out, left_out) = passes::left_out(&problem, (&sought, first), (&shape, place))?.unzip();
    found.held_out = held_out;
    findings(sensor, &unseen, &runs, &mut found, conditions);
    Ok(Some((found, AcrossFindings { block, likely, left_out: left_out.unwrap_or_default() })))
}

/// B u²: the sensitivity's even dependence on the field across, which the catalogue does not have.
fn squared(runs: &[Run<'_>], across: &[Vec<Axis>]) -> Candidate {
    let of = |(run, coils): (&Run<'_>, &Vec<Axis>)| -> Vec<f64> {
        let along = crate::readings::along(run);
        (0..run.context.rows)
            .map(|row| {
                let square: f64 = coils.iter().map(|coil| (run.coil_nt(*coil, row) / FULL_NT).powi(2)).sum();
                along[row] / FULL_NT * square
            })
            .collect()
    };
    Candidate {
        name: "sensitivity_even",
        parameter: "departure_nt",
        column: runs.iter().zip(across).map(of).collect(),
    }
}

fn significance(fit: &Fit, places: &[usize], freedom: f64) -> TestResult {
    let values = Mat::from_fn(places.len(), 1, |i, _| fit.values[places[i]]);
    let form = estimate::correlated::Whitening::of(&[fit.scatter_of(places)])
        .map(|white| white.apply(values.as_ref()).squared_norm_l2())
        .unwrap_or(0.0);
    let count = places.len() as f64;
    TestResult { statistic: form / count, p_value: stats::f_p(form / count, count, freedom) }
}

/// k and O at each field across, and whether they differ beyond a lean of the sensor.
fn levels_of(
    lean: &Problem<'_, '_>,
    across: &Across,
    shape: &Shape,
    found: &mut CrossFieldFit,
) -> Result<()> {
    let runs = lean.runs;
    let mut groups: Vec<(usize, Vec<usize>)> = Vec::new();
    let mut fields: Vec<Vec<f64>> = Vec::new();
    for (number, run) in runs.iter().enumerate() {
        let from = groups.len();
        for row in &run.rows {
            let at: Vec<f64> = across.coils[number].iter().map(|coil| run.coil_nt(*coil, *row)).collect();
            let same = |other: &Vec<f64>| at.iter().zip(other).all(|(a, b)| (a - b).abs() < ACROSS * FULL_NT);
            match fields[from..].iter().position(same) {
                Some(group) => groups[from + group].1.push(*row),
                None if groups.len() == MOST_LEVELS => return Ok(()),
                None => {
                    groups.push((number, vec![*row]));
                    fields.push(at);
                }
            }
        }
    }
    if groups.iter().any(|(_, rows)| rows.len() < LEVEL) {
        return Ok(());
    }
    let (constants, _) = levels::constants(runs, &groups, shape)?;
    let mut columns = CrossFieldLevels::default();
    for (((number, _), field), (k, offset)) in groups.iter().zip(&fields).zip(&constants) {
        let largest =
            (0..field.len()).max_by(|a, b| field[*a].abs().total_cmp(&field[*b].abs())).unwrap_or(0);
        columns.recording.push(*number);
        columns.coil.push(across.coils[*number][largest].to_string());
        columns.across_nt.push(field[largest]);
        columns.sensitivity.push(k.0);
        columns.sensitivity_std.push(k.1);
        columns.offset_nt.push(offset.0);
        columns.offset_std_nt.push(offset.1);
    }
    found.levels = columns;
    // Own k and O for every field across, against a lean alone.
    let mut unknowns = levels::polynomial(runs);
    unknowns.extend(levels::lines(runs, &groups));
    let (full, lean) = (lean.with(unknowns).solve()?, lean.solve()?);
    let (above, below) = (lean.linear.freedom - full.linear.freedom, full.linear.freedom);
    if above >= 1.0 && below >= 1.0 {
        let fall = (lean.sum_of_squares() - full.sum_of_squares()).max(0.0);
        let f = fall / above / full.linear.variance_factor;
        found.difference = Some(FTest { f, above, below, p_value: stats::f_p(f, above, below) });
    }
    Ok(())
}

fn findings(
    sensor: Axis,
    unseen: &[Sought],
    runs: &[Run<'_>],
    found: &mut CrossFieldFit,
    conditions: &Conditions,
) {
    let missing: Vec<String> =
        unseen.iter().map(|one| format!("{}.{}", one.kind.name(), one.name())).collect();
    if !missing.is_empty() {
        let more = if missing.len() == 1 && missing[0].ends_with("mixed_nt") {
            "both transverse fields must be applied at once"
        } else if found.offset.is_empty() {
            "a slightly misaligned sensor would look the same: record transverse fields of both signs and zero"
        } else {
            "the other transverse direction was not recorded: turn the block by 90° about the sensor, or drive the other coil"
        };
        let words = format!("{} cannot be determined from these recordings: {more}", missing.join(", "));
        found.findings.push(Code::NotDetermined.said(words));
    }
    let p = found.significance.map_or(1.0, |test| test.p_value);
    found.findings.push(if found.offset.is_empty() {
        Code::NotDetermined
            .said(format!("whether transverse fields affect sensor {sensor} cannot be determined"))
    } else if p < FOUND_BELOW {
        Code::CrossField.said(format!("transverse fields affect sensor {sensor} ({})", p_value(p)))
    } else {
        Code::CrossFieldNotSignificant.said(format!(
            "transverse fields do not affect sensor {sensor} beyond the experimental error ({})",
            p_value(p)
        ))
    });
    for departure in found.departures.iter().filter(|departure| departure.found) {
        found.findings.push(Code::SquaredCrossField.said(format!(
            "k also depends on the square of the transverse field (adjusted {}), which no effect of the catalogue describes",
            p_value(departure.p_adjusted)
        )));
    }
    found.findings.extend(conditions.not_recorded(runs));
}
