//! What fields across a sensor do to it ("Measurement of Orthogonal Field Effects on Sensitivity and Offset").
//!
//! A sensor that is not quite along its coil reads a share of the field across, which is odd in that field and does not
//! depend on the field along: it belongs to the axes and is kept apart. What is even in the field across (the catalogue's
//! `cross_field`) or goes with the field along (`cross_field_sensitivity`) is the sensor's own.

use common::number::p_value;
use common::{
    Axis, CrossFieldFit, CrossFieldLevels, Document, Error as Fault, FTest, HeldOut, Misalignment, Quantity,
    TestResult, procedure,
};
use estimate::stats;
use faer::Mat;
use physics::Kind;

use crate::Error;
use crate::conditions::Conditions;
use crate::departure::{self, Candidate, FOUND_BELOW, used, visible_share};
use crate::fit::{self, Fit, Problem, Unknown};
use crate::levels;
use crate::readings::{Run, code_width, runs};
use crate::shape::Shape;

/// A field across that moves by less than this share of the field along is none.
const ACROSS: f64 = 0.01;
/// A parameter that moves no reading by this share of what its neighbours do, or of which less is left beside the others,
/// cannot be told.
const VISIBLE: f64 = 0.2;
/// Fields count in units of the catalogue's reference field.
const FULL_NT: f64 = 50_000.0;
/// Parts into which readings are dealt out to be left out one after the other.
const FOLDS: usize = 3;
const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;

/// One parameter that is sought.
struct Sought {
    kind: Kind,
    number: usize,
    column: Vec<Vec<f64>>,
}

/// Coefficients of a sensor; None without a recording.
pub fn coefficients(
    document: &Document,
    sensor: Axis,
    noise: &dyn Fn(f64) -> Shape,
    conditions: &Conditions,
    axes_std_deg: f64,
) -> Result<Option<CrossFieldFit>, Error> {
    let runs = runs(document, procedure::CROSS_FIELD, sensor)?;
    if runs.is_empty() {
        return Ok(None);
    }
    let across = across(&runs)?;
    let mut found = CrossFieldFit {
        recordings: runs.iter().map(|run| run.context.recording.id.clone()).collect(),
        ..CrossFieldFit::default()
    };
    if let Some(run) = runs.iter().find(|run| !run.oriented) {
        let found = "no orientation of the block";
        let expected = "`orientation` or `theodolite`: which sides of the sensor the fields across come from";
        return Err(Fault::document(format!("{}.conditions", run.path), found, expected).into());
    }
    let k = runs[0].basic.sensors[sensor.index()].sensitivity;
    let shape = noise(runs.iter().find_map(|run| code_width(document, run)).unwrap_or(0.0) * k);
    let (effects, known) = conditions.effects_in(&runs);
    let mut knowns = fit::coils(document, &runs)?;
    knowns.extend(known);
    let mut unknowns = misalignments(&runs, &across);
    let turned = unknowns.len();
    unknowns.extend(levels::own_constants(&runs, sensor));
    let allowed = fit::noise(&runs, &shape)?;
    let base = Problem { runs: &runs, effects, unknowns, known: knowns, allowed: &allowed };
    let without = base.solve()?;
    let (sought, unseen) = sought(&runs, &without.design)?;
    let mut unknowns = base.unknowns.clone();
    unknowns.extend(sought.iter().map(|one| Unknown::Column(one.column.clone())));
    let problem = Problem { unknowns, ..base };
    let candidates = [squared(&runs, &across)];
    let allowed = departure::noise_called_for(&problem, &candidates)?;
    let problem = Problem { allowed: &allowed, ..problem };
    let extended = departure::extend(&problem, &candidates)?;
    let fit = &extended.fit;
    let first = without.values.len();
    let count = sought.len();
    let mut covariance: Vec<Vec<f64>> =
        (0..count).map(|i| (0..count).map(|j| fit.covariance(first + i, first + j)).collect()).collect();
    unknown_axes(document, &runs, &problem, (&sought, &unseen), fit, axes_std_deg, &mut covariance)?;
    for (at, one) in sought.iter().enumerate() {
        let info = &one.kind.parameters()[one.number];
        let quantity = Quantity::new(fit.values[first + at], covariance[at][at].sqrt());
        let (name, group) = match one.kind {
            Kind::CrossField => ("offset", &mut found.offset),
            _ => ("sensitivity", &mut found.sensitivity),
        };
        group.insert(info.name.into(), quantity);
        found.covariance_order.push(format!("{name}.{}", info.name));
    }
    found.covariance = covariance;
    found.departures = extended.departures;
    found.noise = fit.noise.clone();
    found.significance = Some(significance(fit, first, count));
    found.misalignments = named(&runs, &across, fit, turned);
    levels_of(&runs, &across, &shape, &problem, turned, &mut found)?;
    found.held_out = held_out(&problem, first, &shape)?;
    findings(sensor, &unseen, &runs, &mut found, conditions);
    Ok(Some(found))
}

/// The coils across the sensor that were driven in each run.
fn across(runs: &[Run<'_>]) -> Result<Vec<Vec<Axis>>, Error> {
    runs.iter()
        .map(|run| {
            let size = |coil: Axis| {
                let of = || run.rows.iter().map(|row| run.coil_nt(coil, *row));
                of().fold(f64::NEG_INFINITY, f64::max) - of().fold(f64::INFINITY, f64::min)
            };
            let along = size(run.coil);
            let mut coils: Vec<Axis> = Vec::new();
            for coil in Axis::ALL {
                let apart = coils.iter().all(|other| !together(run, coil, *other));
                if coil != run.coil && size(coil) > ACROSS * along && apart {
                    coils.push(coil);
                }
            }
            if coils.is_empty() {
                let found = format!("no field across sensor {} that changes", run.sensor);
                let expected = "drive on a coil across the sensor, zero and both signs in one recording, with one setting of the sensor";
                return Err(Fault::document(format!("{}.columns", run.path), found, expected).into());
            }
            Ok(coils)
        })
        .collect()
}

/// Whether two coils are driven in proportion: a lean towards the one cannot be told from one towards the other.
fn together(run: &Run<'_>, coil: Axis, other: Axis) -> bool {
    let column = |coil: Axis| -> Vec<f64> { run.rows.iter().map(|row| run.coil_nt(coil, *row)).collect() };
    let (one, two) = (column(coil), column(other));
    let with = Mat::from_fn(one.len(), 2, |i, j| if j == 0 { 1.0 } else { two[i] });
    visible_share(&with, &one) < ACROSS
}

fn series(runs: &[Run<'_>], only: usize, value: &dyn Fn(&Run<'_>, usize) -> f64) -> Vec<Vec<f64>> {
    let of = |(number, run): (usize, &Run<'_>)| -> Vec<f64> {
        (0..run.context.rows).map(|row| if number == only { value(run, row) } else { 0.0 }).collect()
    };
    runs.iter().enumerate().map(of).collect()
}

/// How far the sensor leans towards each coil across it, rad: one for each run and coil.
fn misalignments(runs: &[Run<'_>], across: &[Vec<Axis>]) -> Vec<Unknown> {
    let pairs =
        across.iter().enumerate().flat_map(|(number, coils)| coils.iter().map(move |coil| (number, *coil)));
    pairs
        .map(|(number, coil)| Unknown::Column(series(runs, number, &|run, row| run.coil_nt(coil, row))))
        .collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

/// The parameters of the catalogue's effects that these recordings can tell apart, and those that they cannot.
fn sought(runs: &[Run<'_>], design: &Mat<f64>) -> Result<(Vec<Sought>, Vec<Sought>), Error> {
    let (mut seen, mut unseen): (Vec<Sought>, Vec<Sought>) = (Vec::new(), Vec::new());
    for kind in [Kind::CrossField, Kind::CrossFieldSensitivity] {
        let sizes = (0..kind.parameters().len())
            .map(|number| Ok(largest(&used(runs, &Candidate::effect(kind, number, runs)?.column))));
        let most = sizes.collect::<Result<Vec<f64>, Error>>()?.into_iter().fold(0.0, f64::max);
        for number in 0..kind.parameters().len() {
            let column = Candidate::effect(kind, number, runs)?.column;
            let others: Vec<Vec<f64>> = seen.iter().map(|one| used(runs, &one.column)).collect();
            let beside = Mat::from_fn(design.nrows(), design.ncols() + others.len(), |i, j| {
                if j < design.ncols() { design[(i, j)] } else { others[j - design.ncols()][i] }
            });
            let values = used(runs, &column);
            let size = largest(&values);
            let one = Sought { kind, number, column };
            if size > VISIBLE * most && visible_share(&beside, &values) > VISIBLE {
                seen.push(one);
            } else {
                unseen.push(one);
            }
        }
    }
    Ok((seen, unseen))
}

/// B u²: the sensitivity's even dependence on the field across, which the catalogue does not have.
fn squared(runs: &[Run<'_>], across: &[Vec<Axis>]) -> Candidate {
    let of = |(run, coils): (&Run<'_>, &Vec<Axis>)| -> Vec<f64> {
        let along = crate::sensitivity::along(run);
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

/// Adds what is not known of the directions: parameters that cannot be told are taken as zero, give or take the largest that
/// was found; without measured axes the fields across may be turned about the sensor by `axes_std_deg`.
fn unknown_axes(
    document: &Document,
    runs: &[Run<'_>],
    problem: &Problem<'_, '_>,
    (sought, unseen): (&[Sought], &[Sought]),
    fit: &Fit,
    axes_std_deg: f64,
    covariance: &mut [Vec<f64>],
) -> Result<(), Error> {
    let first = problem.unknowns.len() - sought.len();
    let size = |kind: Kind| {
        let of = sought.iter().enumerate().filter(|(_, one)| one.kind == kind);
        of.map(|(at, _)| fit.values[first + at].abs()).fold(0.0, f64::max)
    };
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    let known = axes.is_some_and(|axes| {
        let given = |part: &Option<common::AxesDirections>| part.as_ref().is_some_and(|p| p.matrix.is_some());
        given(&axes.sensors) && given(&axes.coils)
    });
    let turn = if known { 0.0 } else { axes_std_deg.to_radians() };
    let mut add = |column: Vec<Vec<f64>>, std: f64| -> Result<(), Error> {
        let shift = estimate::linear::fit(fit.design.as_ref(), &used(runs, &column), None)?.coefficients;
        for (i, row) in covariance.iter_mut().enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                *value += std * std * shift[first + i] * shift[first + j];
            }
        }
        Ok(())
    };
    for one in unseen {
        add(one.column.clone(), size(one.kind))?;
    }
    if turn > 0.0 {
        // A turn by ρ brings ρ u² of the mixed term and ρ (u² − v²) mixes, of the size of what was found.
        for (number, _) in runs.iter().enumerate() {
            let square = series(runs, number, &|run, row| {
                let others = Axis::ALL.into_iter().filter(|coil| *coil != run.coil);
                others.map(|coil| (run.coil_nt(coil, row) / FULL_NT).powi(2)).sum()
            });
            add(square, turn * size(Kind::CrossField))?;
            let along: Vec<Vec<f64>> = runs.iter().map(crate::sensitivity::along).collect();
            let product = series(runs, number, &|run, row| {
                let others = Axis::ALL.into_iter().filter(|coil| *coil != run.coil);
                along[number][row] / FULL_NT
                    * others.map(|coil| run.coil_nt(coil, row) / FULL_NT).sum::<f64>()
            });
            add(product, turn * size(Kind::CrossFieldSensitivity))?;
        }
    }
    Ok(())
}

/// χ² of all the parameters together.
fn significance(fit: &Fit, first: usize, count: usize) -> TestResult {
    let block = Mat::from_fn(count, count, |i, j| fit.scatter[(first + i, first + j)]);
    let values = Mat::from_fn(count, 1, |i, _| fit.values[first + i]);
    let form = estimate::correlated::Whitening::of(std::slice::from_ref(&block))
        .map(|white| white.apply(values.as_ref()).squared_norm_l2())
        .unwrap_or(0.0);
    let f = form / count as f64;
    TestResult { statistic: f, p_value: stats::f_p(f, count as f64, fit.linear.freedom) }
}

fn named(runs: &[Run<'_>], across: &[Vec<Axis>], fit: &Fit, turned: usize) -> Vec<Misalignment> {
    let pairs =
        across.iter().enumerate().flat_map(|(number, coils)| coils.iter().map(move |coil| (number, *coil)));
    pairs
        .take(turned)
        .enumerate()
        .map(|(at, (number, coil))| Misalignment {
            recording: runs[number].context.recording.id.clone(),
            coil: coil.to_string(),
            angle_arcsec: Quantity::new(fit.values[at] / ARCSEC, fit.covariance(at, at).sqrt() / ARCSEC),
        })
        .collect()
}

/// k and O at each field across, and whether they differ beyond a lean of the sensor.
fn levels_of(
    runs: &[Run<'_>],
    across: &[Vec<Axis>],
    shape: &Shape,
    problem: &Problem<'_, '_>,
    turned: usize,
    found: &mut CrossFieldFit,
) -> Result<(), Error> {
    let mut groups: Vec<(usize, Vec<usize>)> = Vec::new();
    let mut fields: Vec<Vec<f64>> = Vec::new();
    for (number, run) in runs.iter().enumerate() {
        let from = groups.len();
        for row in &run.rows {
            let at: Vec<f64> = across[number].iter().map(|coil| run.coil_nt(*coil, *row)).collect();
            let same = |other: &Vec<f64>| at.iter().zip(other).all(|(a, b)| (a - b).abs() < ACROSS * FULL_NT);
            match fields[from..].iter().position(same) {
                Some(group) => groups[from + group].1.push(*row),
                None => {
                    groups.push((number, vec![*row]));
                    fields.push(at);
                }
            }
        }
    }
    if groups.iter().any(|(_, rows)| rows.len() < 3) {
        return Ok(());
    }
    let (constants, _) = levels::constants(runs, &groups, shape)?;
    let mut columns = CrossFieldLevels::default();
    for (((number, _), field), (k, offset)) in groups.iter().zip(&fields).zip(&constants) {
        let largest =
            (0..field.len()).max_by(|a, b| field[*a].abs().total_cmp(&field[*b].abs())).unwrap_or(0);
        columns.recording.push(*number);
        columns.coil.push(across[*number][largest].to_string());
        columns.across_nt.push(field[largest]);
        columns.sensitivity.push(k.0);
        columns.sensitivity_std.push(k.1);
        columns.offset_nt.push(offset.0);
        columns.offset_std_nt.push(offset.1);
    }
    found.levels = columns;
    // Own k and O for every field across, against a lean alone.
    let lean = problem.with(problem.unknowns[..problem.unknowns.len() - count(found)].to_vec()).solve()?;
    let mut unknowns = polynomial(problem, turned, found);
    for (number, rows) in &groups {
        let along: Vec<Vec<f64>> = runs.iter().map(crate::sensitivity::along).collect();
        unknowns
            .push(Unknown::Column(series(runs, *number, &|_, row| f64::from(u8::from(rows.contains(&row))))));
        unknowns.push(Unknown::Column(series(runs, *number, &|_, row| {
            if rows.contains(&row) { along[*number][row] } else { 0.0 }
        })));
    }
    let full = problem.with(unknowns).solve()?;
    let above = lean.linear.freedom - full.linear.freedom;
    if above >= 1.0 && full.linear.freedom >= 1.0 {
        let f =
            (lean.sum_of_squares() - full.sum_of_squares()).max(0.0) / above / full.linear.variance_factor;
        let below = full.linear.freedom;
        found.difference = Some(FTest { f, above, below, p_value: stats::f_p(f, above, below) });
    }
    Ok(())
}

fn count(found: &CrossFieldFit) -> usize {
    found.offset.len() + found.sensitivity.len()
}

/// The columns of the sensor's polynomial alone: a lean is in the constants of each field.
fn polynomial(problem: &Problem<'_, '_>, turned: usize, found: &CrossFieldFit) -> Vec<Unknown> {
    let end = problem.unknowns.len() - count(found);
    let columns = problem.unknowns[..end].iter().enumerate();
    columns
        .filter(|(at, unknown)| *at >= turned && matches!(unknown, Unknown::Column(_)))
        .map(|(_, unknown)| unknown.clone())
        .collect()
}

/// Rms of readings that were left out: with the constants and the lean alone, and corrected for the field across.
fn held_out(problem: &Problem<'_, '_>, first: usize, shape: &Shape) -> Result<Option<HeldOut>, Error> {
    let mut sums = [0.0; 2];
    let mut readings = 0;
    for fold in 0..FOLDS {
        let mut kept: Vec<Run<'_>> = problem.runs.to_vec();
        for run in &mut kept {
            run.rows = run
                .rows
                .iter()
                .copied()
                .enumerate()
                .filter(|(i, _)| i % FOLDS != fold)
                .map(|(_, r)| r)
                .collect();
        }
        let allowed = fit::noise(&kept, shape)?;
        for (which, unknowns) in [&problem.unknowns[..first], &problem.unknowns[..]].into_iter().enumerate() {
            let reduced = Problem {
                runs: &kept,
                effects: problem.effects.clone(),
                unknowns: unknowns.to_vec(),
                known: Vec::new(),
                allowed: &allowed,
            };
            let Ok(fit) = reduced.solve() else { return Ok(None) };
            if fit.linear.rank < unknowns.len() {
                return Ok(None);
            }
            let missed = reduced.missed(&fit, problem.runs, &|i| i % FOLDS == fold)?;
            sums[which] += missed.iter().map(|r| r * r).sum::<f64>();
            readings += if which == 0 { missed.len() } else { 0 };
        }
    }
    let rms = sums.map(|sum| (sum / readings as f64).sqrt());
    Ok((readings > 0).then_some(HeldOut { before_nt: rms[0], after_nt: rms[1], readings }))
}

fn findings(
    sensor: Axis,
    unseen: &[Sought],
    runs: &[Run<'_>],
    found: &mut CrossFieldFit,
    conditions: &Conditions,
) {
    let missing: Vec<String> = unseen
        .iter()
        .map(|one| format!("{}.{}", one.kind.name(), one.kind.parameters()[one.number].name))
        .collect();
    if !missing.is_empty() {
        let more = if missing.len() == 1 && missing[0].ends_with("mixed_nt") {
            "it needs both fields across at once"
        } else if found.offset.is_empty() {
            "a sensor that is not quite along its coil would do the same: fields of both signs across it are needed, and none"
        } else {
            "fields on the other side of the sensor were not recorded: turn the block by 90° about the sensor, or drive the other coil"
        };
        found.findings.push(format!("{} cannot be told from these recordings; {more}", missing.join(", ")));
    }
    let p = found.significance.map_or(1.0, |test| test.p_value);
    found.findings.push(if found.offset.is_empty() {
        format!("whether fields across change sensor {sensor} cannot be told")
    } else if p < FOUND_BELOW {
        format!("fields across change sensor {sensor} ({})", p_value(p))
    } else {
        format!("fields across do not change sensor {sensor} beyond the experimental error ({})", p_value(p))
    });
    for departure in found.departures.iter().filter(|departure| departure.found) {
        found.findings.push(format!(
            "k also depends on the square of the field across (adjusted {}), which no effect of the catalogue describes",
            p_value(departure.p_adjusted)
        ));
    }
    found.findings.extend(conditions.not_recorded(runs));
}
