//! From readings to a solution with its uncertainty.

use common::Document;
use estimate::influence::Influence;
use estimate::{Fit, Options as Iteration, Problem, robust, stats};
use faer::Mat;
use physics::frames::ARCSEC;

use crate::start::{self, Beginning};
use crate::unknowns::Unknown;
use crate::{AxesProblem, AxesState, Error, Freedom, Observations, Options, freedom, rank, readings};

/// A χ² less probable than this is not taken for chance: the uncertainties are then scaled to the residuals.
const CHI_SQUARED_P: f64 = 1e-3;
/// A direction that is known to no better than this is not known, rad.
const LARGEST_STD: f64 = 3600.0 * ARCSEC;

/// The directions and all that stands behind them.
#[derive(Clone, Debug)]
pub struct Solution {
    /// What was allowed to move.
    pub freedom: Freedom,
    /// The minimum.
    pub fit: Fit<AxesState>,
    /// What each unknown of the fit means.
    pub meaning: Vec<Unknown>,
    /// Covariance of the unknowns.
    pub covariance: Mat<f64>,
    /// Factor on the readings' standard deviations.
    pub noise_factor: f64,
    /// Where the standard deviations come from, in words.
    pub noise_source: String,
    /// χ² over the declared noise with its probability, where noise is declared.
    pub chi_squared: Option<(f64, f64)>,
    /// Degrees of freedom left.
    pub degrees_of_freedom: f64,
    /// Factor from a standard uncertainty to a 95 % interval.
    pub coverage_factor: f64,
    /// Observed less predicted, nT.
    pub residuals_nt: Vec<f64>,
    /// Leverage and leave-one-out of every reading, in units of its standard deviation.
    pub influence: Vec<Influence>,
    /// Weights of a robust fit.
    pub weights: Option<Vec<f64>>,
    /// Readings that do not belong to the rest: number, leave-one-out, t, adjusted p.
    pub doubtful: Vec<readings::Doubt>,
    /// The steps of the first, plain iteration, in units of the declared noise.
    pub steps: Vec<estimate::Step>,
    /// What looks wrong, in words.
    pub findings: Vec<String>,
}

/// Finds the directions, or says what is missing for them.
pub fn solve(document: &Document, observations: &Observations, options: &Options) -> Result<Solution, Error> {
    let Beginning { state: start, mut findings } = start::begin(document, observations, options)?;
    let freedom = freedom::freedom(document, observations, options)?;
    let problem = AxesProblem::new(observations, &freedom, 1.0);
    let (count, unknowns) = (problem.readings(), problem.unknowns());
    let turns = problem.meaning().iter().filter(|unknown| unknown.is_turn()).count();
    if count < turns {
        return Err(Error::RankShort(format!(
            "{count} readings for the {turns} unknowns of {} sensors and {} coils; drive each coil in each orientation, and \
             record more orientations",
            observations.sensors.len(),
            observations.coils.len()
        )));
    }
    let plain = estimate::solve(&problem, start, None, &Iteration::default())?;
    let unseen = rank::unseen_turns(&problem, &plain);
    if !unseen.is_empty() {
        return Err(Error::RankShort(rank::explain(&problem, &freedom, &plain.state, &unseen)));
    }
    let doubtful = readings::doubtful(&problem, &plain, observations.declared)?;
    let steps = plain.steps.clone();

    let freedom_left = |fit: &Fit<AxesState>, weights: Option<&[f64]>| {
        let leverage: f64 = fit.svd.leverage()[..count].iter().sum();
        weights.map_or(count as f64, |weights| weights.iter().sum()) - leverage
    };
    let (fit, weights) = estimated(&problem, plain.state, observations.declared, options)?;
    let degrees_of_freedom = freedom_left(&fit, weights.as_deref());
    let sum_of_squares = |fit: &Fit<AxesState>| fit.residual[..count].iter().map(|r| r * r).sum::<f64>();
    let chi_squared = observations.declared.then(|| {
        let chi_squared = sum_of_squares(&fit);
        (chi_squared, stats::chi_squared_p(chi_squared, degrees_of_freedom))
    });
    let scatter = chi_squared.is_none_or(|(_, p)| p < CHI_SQUARED_P && degrees_of_freedom >= 1.0);
    if scatter && degrees_of_freedom < 0.5 {
        return Err(Error::RankShort(format!(
            "{count} readings for {unknowns} unknowns leave none to judge the noise by; declare it in instrument.noise, or \
             record more orientations"
        )));
    }
    let (mut fit, mut weights, mut noise_factor) = (fit, weights, 1.0);
    if scatter {
        // With priors the fit changes with the noise, and the noise with the fit: a few rounds settle it.
        let rounding = 1e-13 * observations.readings.iter().map(|r| r.value_nt.abs()).fold(0.0, f64::max);
        for _ in 0..30 {
            let next = noise_factor * (sum_of_squares(&fit) / freedom_left(&fit, weights.as_deref())).sqrt();
            let next = next.max(rounding);
            let settled = (next / noise_factor - 1.0).abs() < 1e-6;
            noise_factor = next;
            let problem = AxesProblem::new(observations, &freedom, noise_factor);
            (fit, weights) = estimated(&problem, fit.state, true, options)?;
            if settled {
                break;
            }
        }
    }
    let noise_source = match (chi_squared, scatter) {
        (None, _) => "residuals".to_string(),
        (Some(_), false) => "declared".to_string(),
        (Some((chi_squared, p)), true) => {
            findings.push(format!(
                "the readings scatter {noise_factor:.2} times as much as declared (χ² = {chi_squared:.1} for \
                 {degrees_of_freedom:.0} degrees of freedom, p = {p:.1e}); the uncertainties are scaled up to it"
            ));
            "declared, scaled to the residuals".to_string()
        }
    };
    let problem = AxesProblem::new(observations, &freedom, noise_factor);
    let covariance = fit.svd.covariance();
    check_certainty(&problem, &freedom, &fit.state, &covariance)?;
    let influence = readings::influence(&problem, &fit, weights.as_deref());
    Ok(Solution {
        meaning: problem.meaning().to_vec(),
        residuals_nt: problem.residuals_nt(&fit.state),
        coverage_factor: stats::coverage_factor(
            0.95,
            if scatter { degrees_of_freedom } else { f64::INFINITY },
        ),
        covariance,
        noise_factor,
        noise_source,
        chi_squared,
        degrees_of_freedom,
        influence,
        weights,
        doubtful,
        steps,
        findings,
        fit,
        freedom,
    })
}

/// A plain fit, or a robust one where it was asked for.
fn estimated(
    problem: &AxesProblem<'_>,
    start: AxesState,
    known_scale: bool,
    options: &Options,
) -> Result<(Fit<AxesState>, Option<Vec<f64>>), Error> {
    if options.robust {
        let (fit, weights) = robust::solve_robust(problem, start, known_scale, &Iteration::default())?;
        Ok((fit, Some(weights)))
    } else {
        Ok((estimate::solve(problem, start, None, &Iteration::default())?, None))
    }
}

/// Directions whose uncertainty is beyond all use are refused like a short rank.
fn check_certainty(
    problem: &AxesProblem<'_>,
    freedom: &Freedom,
    state: &AxesState,
    covariance: &Mat<f64>,
) -> Result<(), Error> {
    let worst = problem
        .meaning()
        .iter()
        .enumerate()
        .filter(|(_, unknown)| unknown.is_turn())
        .map(|(place, _)| covariance[(place, place)])
        .fold(0.0, f64::max);
    if worst.sqrt() <= LARGEST_STD {
        return Ok(());
    }
    // The weakest combination: a few rounds of the power method on the covariance of the turns.
    let turns: Vec<bool> = problem.meaning().iter().map(|unknown| unknown.is_turn()).collect();
    let size = turns.len();
    let mut vector: Vec<f64> = turns.iter().map(|turn| f64::from(*turn)).collect();
    for _ in 0..100 {
        let product: Vec<f64> = (0..size)
            .map(|i| if turns[i] { (0..size).map(|j| covariance[(i, j)] * vector[j]).sum() } else { 0.0 })
            .collect();
        let norm = product.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
        vector = product.into_iter().map(|x| x / norm).collect();
    }
    let explained = rank::explain(problem, freedom, state, &[vector]);
    Err(Error::RankShort(format!(
        "{explained} (formally the rank is full, but a direction would be uncertain by {:.1}°)",
        worst.sqrt().to_degrees()
    )))
}
