//! From readings to a solution with its uncertainty.

use common::{Axis, Document, Finding};
use estimate::influence::{self, Influence};
use estimate::{Fit, Options as Iteration, Problem, stats};
use faer::Mat;
use nalgebra::Matrix3;
use physics::frames::tangents;

use crate::scatter::{self, Settled};
use crate::unknowns::{Unknown, place, turns};
use crate::{
    AxesProblem, AxesState, Error, Freedom, NoiseFactors, NoiseSource, Observations, Options, Result,
    certainty, doubts, freedom, rank, start,
};

/// Singular values below this share of the largest are held still where the iteration wanders along them.
const COARSE_RANK: f64 = 1e-3;

#[derive(Clone, Debug)]
pub struct Solution {
    pub freedom: Freedom,
    pub fit: Fit<AxesState>,
    /// What each unknown of the fit means.
    pub meaning: Vec<Unknown>,
    pub covariance: Mat<f64>,
    /// Factors on the readings' standard deviations.
    pub noise: NoiseFactors,
    /// Where the standard deviations come from, in words.
    pub noise_source: String,
    /// χ² over the declared noise with its probability, where noise is declared.
    pub chi_squared: Option<(f64, f64)>,
    pub degrees_of_freedom: f64,
    /// Degrees of freedom of the noise where it was taken from the scatter of the readings; infinite where it
    /// is known.
    pub noise_freedom: f64,
    /// Factor from a standard uncertainty to a 95 % interval.
    pub coverage_factor: f64,
    /// Observed less predicted, nT.
    pub residuals_nt: Vec<f64>,
    /// Leverage and leave-one-out of every reading, in units of its standard deviation.
    pub influence: Vec<Influence>,
    pub weights: Option<Vec<f64>>,
    /// Outliers: number, leave-one-out, t, adjusted p.
    pub doubtful: Vec<doubts::Doubt>,
    /// The steps of the first, plain iteration, in units of the declared noise.
    pub steps: Vec<estimate::Step>,
    pub findings: Vec<Finding>,
}

impl Solution {
    /// The 9×n matrices from the unknowns to the elements of the directions of sensors and of coils, column
    /// by column.
    pub fn turns(&self, observations: &Observations) -> [Mat<f64>; 2] {
        let of = |axes: &[Axis], matrix: &Matrix3<f64>, unknown: fn(Axis, usize) -> Unknown| {
            let mut map = Mat::zeros(9, self.meaning.len());
            for &axis in axes {
                let Some(place) = place(&self.meaning, unknown(axis, 0)) else { continue };
                for (k, tangent) in tangents(&matrix.column(axis.index()).into_owned()).iter().enumerate() {
                    (0..3).for_each(|row| map[(3 * axis.index() + row, place + k)] = tangent[row]);
                }
            }
            map
        };
        let AxesState { mu, eta, .. } = &self.fit.state;
        [of(&observations.sensors, mu, Unknown::Sensor), of(&observations.coils, eta, Unknown::Coil)]
    }
}

/// Finds the directions, or says what is missing for them.
pub fn solve(document: &Document, observations: &Observations, options: &Options) -> Result<Solution> {
    // The unknowns, and whether the orientations show them.
    let (start, mut findings) = start::begin(document, observations, options)?;
    let freedom = freedom::freedom(document, observations, options)?;
    let problem = AxesProblem::new(observations, &freedom, NoiseFactors::ONE);
    let plain = first_fit(&problem, start)?;
    let unseen = plain.svd.unseen(&turns(&problem.meaning));
    if !unseen.is_empty() {
        return Err(Error::Unanswerable(rank::explain(&problem, &freedom, &plain.state, &unseen)));
    }

    // Single readings, then constants, that do not belong to the rest.
    let known_scale = observations.noise != NoiseSource::Residuals;
    let doubtful = doubts::doubtful(&problem, &plain, known_scale)?;
    let steps = plain.steps.clone();
    let mut trusted = vec![1.0; problem.readings()];
    doubtful.iter().for_each(|doubt| trusted[doubt.reading] = 0.0);
    let (freedom, contradicted) = doubts::settle(observations, freedom, &plain.state, &trusted, known_scale)?;
    findings.extend(contradicted);

    // The fit and its noise.
    let settled = scatter::settle(observations, &freedom, plain.state, options)?;
    let (noise, noise_freedom, noise_source) = (settled.noise, settled.freedom(), settled.source());
    let scatters = settled.findings();
    let Settled { estimate, chi_squared, .. } = settled;
    let problem = AxesProblem::new(observations, &freedom, noise);
    let fit = if options.robust { unweighted(&problem, estimate.fit)? } else { estimate.fit };
    let residuals_nt = problem.residuals_nt(&fit.state);
    let covariance = fit.svd.covariance();

    // Whether that is an answer.
    certainty::check(&problem, &freedom, &fit.state, &covariance, &residuals_nt)?;
    if let Some(weights) = &estimate.weights {
        findings.extend(certainty::rejected(&problem, weights, &residuals_nt)?);
    }
    findings.extend(scatters);
    Ok(Solution {
        meaning: problem.meaning.clone(),
        coverage_factor: stats::coverage_factor(0.95, noise_freedom),
        noise_freedom,
        influence: influence::influence(&fit, problem.readings(), false, 0),
        residuals_nt,
        covariance,
        noise,
        noise_source,
        chi_squared,
        degrees_of_freedom: estimate.spread.degrees_of_freedom,
        weights: estimate.weights,
        doubtful,
        steps,
        findings,
        fit,
        freedom,
    })
}

/// The plain fit. Where a combination of turns is all but unseen, the iteration may wander along it; then it
/// is held still, so that what is wrong can be said.
fn first_fit(problem: &AxesProblem<'_>, start: AxesState) -> Result<Fit<AxesState>> {
    match estimate::solve(problem, start.clone(), None, &Iteration::default()) {
        Err(estimate::Error::NotConverged { .. }) => {
            let coarse = Iteration { rank_tolerance: COARSE_RANK, ..Iteration::default() };
            Ok(estimate::solve(problem, start, None, &coarse)?)
        }
        result => Ok(result?),
    }
}

/// The problem with all readings alike at the minimum of a robust fit: the noise factor then makes its
/// covariance.
fn unweighted(problem: &AxesProblem<'_>, fit: Fit<AxesState>) -> Result<Fit<AxesState>> {
    let (residual, jacobian) = estimate::linearised(problem, &fit.state);
    let svd = estimate::Svd::of(jacobian.as_ref(), Iteration::default().rank_tolerance)?;
    let cost = residual.iter().map(|r| r * r).sum();
    Ok(Fit { residual, jacobian, svd, cost, ..fit })
}
