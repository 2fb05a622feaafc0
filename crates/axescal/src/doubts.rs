//! Readings and constants that contradict the rest.
//!
//! A stated uncertainty that is too small would bend the directions, and in the end the noise with them. So
//! each prior is held against what the readings alone say of it: its residual over √(1 − h) is a standard
//! normal number when the statement is true. A constant that is beyond chance is left free, and said.

use common::number::significant;
use common::{Code, Finding};
use estimate::influence;
use estimate::{Fit, Options as Iteration, Problem, stats};

use crate::unknowns::Unknown;
use crate::{AxesProblem, AxesState, Freedom, NoiseFactors, Observations, Result};

/// A reading is called doubtful below this adjusted probability.
const DOUBTFUL_P: f64 = 0.01;
/// More doubtful readings than this are not single faults.
const MOST_DOUBTFUL: usize = 20;
/// A pull less probable than this, among all constants, is not taken for chance.
const VIOLATED_P: f64 = 1e-4;
/// Priors that decide their unknown alone cannot be tested.
const TESTABLE: f64 = 1e-6;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    pub reading: usize,
    /// Reading less the prediction made without it, nT.
    pub leave_one_out_nt: f64,
    /// That over its standard deviation, estimated without it.
    pub t: f64,
    /// Probability that the largest of all is so far out.
    pub p_adjusted: f64,
}

/// Takes out the reading that is furthest from the prediction made without it, as long as that is beyond
/// chance, and fits again: a large fault hides smaller ones, so they are looked for one after the other.
pub fn doubtful(problem: &AxesProblem<'_>, plain: &Fit<AxesState>, declared: bool) -> Result<Vec<Doubt>> {
    let count = problem.readings();
    let mut weights = vec![1.0; count];
    let mut found: Vec<Doubt> = Vec::new();
    let mut fit = plain.clone();
    while found.len() < MOST_DOUBTFUL.min(count / 4) {
        let freedom = fit.degrees_of_freedom() - found.len() as f64 - 1.0;
        if freedom < 2.0 {
            break;
        }
        let all = influence::influence(&fit, count, declared, found.len());
        let furthest = (0..count)
            .filter(|i| weights[*i] > 0.0)
            .max_by(|a, b| all[*a].t.abs().total_cmp(&all[*b].t.abs()));
        let Some(reading) = furthest else { break };
        let p_adjusted = influence::adjusted_p(all[reading].t, freedom, count - found.len());
        if p_adjusted >= DOUBTFUL_P {
            break;
        }
        let leave_one_out_nt = all[reading].leave_one_out * problem.own_std_nt(reading);
        found.push(Doubt { reading, leave_one_out_nt, t: all[reading].t, p_adjusted });
        weights[reading] = 0.0;
        fit = estimate::solve(problem, fit.state, Some(&weights), &Iteration::default())?;
    }
    Ok(found)
}

/// What may move once the constants that the readings contradict are free, and which those are, in words.
/// `weights` leaves doubtful readings out.
pub fn settle(
    observations: &Observations,
    mut freedom: Freedom,
    start: &AxesState,
    weights: &[f64],
    known_scale: bool,
) -> Result<(Freedom, Vec<Finding>)> {
    let solve = |freedom: &Freedom, factor: f64| {
        let problem = AxesProblem::new(observations, freedom, NoiseFactors::both(factor));
        estimate::solve(&problem, start.clone(), Some(weights), &Iteration::default())
    };
    let count: f64 = weights.iter().sum();
    let factor = if known_scale {
        1.0
    } else {
        let fit = solve(&freedom.without_priors(), 1.0)?;
        let leverage: f64 = fit.svd.leverage()[..weights.len()].iter().sum();
        let squares: f64 = fit.residual[..weights.len()].iter().map(|r| r * r).sum();
        (squares / (count - leverage).max(1.0)).sqrt().max(f64::MIN_POSITIVE)
    };
    let mut findings = Vec::new();
    loop {
        let problem = AxesProblem::new(observations, &freedom, NoiseFactors::both(factor));
        let Ok(fit) = solve(&freedom, factor) else { break };
        let left = if known_scale { f64::INFINITY } else { (count - problem.unknowns() as f64).max(1.0) };
        let pulls = pulls(&problem, &fit);
        let constants = pulls.iter().filter(|(unknown, _)| !matches!(unknown, Unknown::Correction(..)));
        let tested = constants.clone().count() as f64;
        let Some((unknown, pull)) = constants.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())) else { break };
        if stats::two_sided_p(*pull, left) * tested >= VIOLATED_P {
            findings.extend(orientations(&pulls));
            break;
        }
        freedom.release(*unknown);
        findings.push(Code::PriorContradicted.about(significant(pull.abs(), 3)).said(format!(
            "the readings put {} {} standard uncertainties from the value that the document states; it was fitted without this prior",
            name(*unknown),
            significant(pull.abs(), 3)
        )));
    }
    let problem = AxesProblem::new(observations, &freedom, NoiseFactors::both(factor));
    if let Ok(fit) = solve(&freedom, factor) {
        findings.extend(known_coils(&problem, &fit));
    }
    Ok((freedom, findings))
}

/// Each unknown with a prior and how far, in standard deviations, the readings pull it.
fn pulls(problem: &AxesProblem<'_>, fit: &Fit<AxesState>) -> Vec<(Unknown, f64)> {
    let leverage = fit.svd.leverage();
    problem
        .prior_rows()
        .filter(|(row, _)| 1.0 - leverage[*row] > TESTABLE)
        .map(|(row, unknown)| (unknown, fit.residual[row] / (1.0 - leverage[row]).sqrt()))
        .collect()
}

/// The theodolites, judged by all their corrections together.
fn orientations(pulls: &[(Unknown, f64)]) -> Option<Finding> {
    let own = pulls.iter().filter(|(unknown, _)| matches!(unknown, Unknown::Correction(..)));
    let corrections: Vec<f64> = own.map(|(_, pull)| *pull).collect();
    let far = corrections.iter().map(|pull| pull.abs()).fold(0.0, f64::max);
    let p = stats::two_sided_p(far, f64::INFINITY) * corrections.len() as f64;
    (!corrections.is_empty() && p < VIOLATED_P).then(|| {
        Code::OrientationContradicted.about(significant(far, 3)).said(format!(
            "the correction of an orientation is {} times the theodolites' uncertainty; read it again, or state a larger uncertainty",
            significant(far, 3)
        ))
    })
}

/// The coils that were given as known, judged by all their turns together.
fn known_coils(problem: &AxesProblem<'_>, fit: &Fit<AxesState>) -> Option<Finding> {
    let leverage = fit.svd.leverage();
    let rows = problem.known_coil_row_numbers();
    let freedom: f64 = rows.clone().map(|row| 1.0 - leverage[row]).sum();
    let squares: f64 = rows.map(|row| fit.residual[row].powi(2)).sum();
    (freedom > 0.5 && stats::chi_squared_p(squares, freedom) < VIOLATED_P).then(|| {
        Code::KnownCoilsContradicted.said("the readings contradict the known directions of the coils; the coils may have moved, or a constant may be wrong")
    })
}

fn name(unknown: Unknown) -> String {
    match unknown {
        Unknown::SensorScale(axis) => format!("the sensitivity of sensor {axis}"),
        Unknown::CoilScale(axis) => format!("the constant of coil {axis}"),
        Unknown::ResidualField(_) => "the residual field".into(),
        Unknown::Offset(axis) => format!("the offset of sensor {axis}"),
        Unknown::Sensor(axis, _) => format!("sensor {axis}"),
        Unknown::Coil(axis, _) => format!("coil {axis}"),
        Unknown::Correction(orientation, _) => format!("orientation {}", orientation + 1),
    }
}
