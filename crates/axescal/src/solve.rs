//! From readings to a solution with its uncertainty.

use common::number::{counted, plural, significant};
use common::{Axis, Code, Document, Finding};
use estimate::influence::{self, Influence};
use estimate::{Fit, Options as Iteration, Problem, stats};
use faer::Mat;
use nalgebra::Matrix3;
use physics::frames::{ARCSEC, tangents};

use crate::scatter::{self, Settled};
use crate::unknowns::{Unknown, place, turns};
use crate::{
    AxesProblem, AxesState, Error, Freedom, NoiseFactors, NoiseSource, Observations, Options, Result, doubts,
    freedom, rank, start,
};

/// Singular values below this share of the largest are held still where the iteration wanders along them.
const COARSE_RANK: f64 = 1e-3;
/// A reading of less weight than this is left out.
const NO_WEIGHT: f64 = 1e-2;
/// A robust fit that leaves out a larger share than this is refused.
const MOST_REJECTED: f64 = 0.25;
/// Noise of a fair reading, as a share of the drive: directions still unknown with it want orientations.
const GOOD_NOISE: f64 = 1e-4;
/// A direction that is known to no better than this is not known, rad.
const LARGEST_STD: f64 = 3600.0 * ARCSEC;

#[derive(Clone, Debug)]
pub struct Solution {
    pub freedom: Freedom,
    pub fit: Fit<AxesState>,
    pub meaning: Vec<Unknown>,
    pub covariance: Mat<f64>,
    /// Factors on the readings' standard deviations.
    pub noise: NoiseFactors,
    /// Where the standard deviations come from, in words.
    pub noise_source: String,
    /// χ² over the declared noise with its probability, where noise is declared.
    pub chi_squared: Option<(f64, f64)>,
    pub degrees_of_freedom: f64,
    /// Degrees of freedom of noise taken from the scatter; infinite where it is known.
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
    /// The 9×n matrices from the unknowns to the elements of sensors' and coils' directions, by column.
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
    check(&problem, &freedom, &fit.state, &covariance, &residuals_nt)?;
    if let Some(weights) = &estimate.weights {
        findings.extend(rejected(&problem, weights, &residuals_nt)?);
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

/// For the covariance: the problem with all readings alike at the minimum of a robust fit.
fn unweighted(problem: &AxesProblem<'_>, fit: Fit<AxesState>) -> Result<Fit<AxesState>> {
    let (residual, jacobian) = estimate::linearised(problem, &fit.state);
    let svd = estimate::Svd::of(jacobian.as_ref(), Iteration::default().rank_tolerance)?;
    let cost = residual.iter().map(|r| r * r).sum();
    Ok(Fit { residual, jacobian, svd, cost, ..fit })
}

/// Directions whose uncertainty is beyond all use are refused: for want of turns where the orientations are
/// to blame, else because the readings do not fit.
fn check(
    problem: &AxesProblem<'_>,
    freedom: &Freedom,
    state: &AxesState,
    covariance: &Mat<f64>,
    residuals_nt: &[f64],
) -> Result<()> {
    let turns = turns(&problem.meaning);
    let worst = turns.iter().map(|&k| covariance[(k, k)]).fold(0.0, f64::max).sqrt();
    if worst <= LARGEST_STD {
        return Ok(());
    }
    if worst / problem.mean_std_nt() * GOOD_NOISE * problem.observations.largest_drive_nt() <= LARGEST_STD {
        return Err(Error::Unanswerable(misfit(problem, residuals_nt)));
    }
    // The weakest combination: a few rounds of the power method on the covariance of the turns.
    let mut weakest = vec![0.0; problem.unknowns()];
    turns.iter().for_each(|&k| weakest[k] = 1.0);
    for _ in 0..100 {
        let mut product = vec![0.0; weakest.len()];
        for &i in &turns {
            product[i] = turns.iter().map(|&j| covariance[(i, j)] * weakest[j]).sum();
        }
        let norm = product.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
        weakest = product.into_iter().map(|x| x / norm).collect();
    }
    let explained = rank::explain(problem, freedom, state, &[weakest]);
    Err(Error::Unanswerable(format!(
        "{explained} (formally the rank is full, but a direction would be uncertain by {}°)",
        significant(worst.to_degrees().min(90.0), 2)
    )))
}

/// What a robust fit left out. A large share is no longer a matter of single readings.
fn rejected(problem: &AxesProblem<'_>, weights: &[f64], residuals_nt: &[f64]) -> Result<Option<Finding>> {
    let out: Vec<usize> = (0..weights.len()).filter(|k| weights[*k] < NO_WEIGHT).collect();
    let readings = counted(weights.len(), "reading");
    if out.len() as f64 > MOST_REJECTED * weights.len() as f64 {
        let (misfit, belong) = (misfit(problem, residuals_nt), plural(out.len(), "belongs", "belong"));
        let out = format!("{} of {readings} {belong} to another model than the rest. {misfit}", out.len());
        return Err(Error::Unanswerable(out));
    }
    Ok((!out.is_empty()).then(|| {
        let mut orientations: Vec<usize> =
            out.iter().map(|&k| problem.observations.readings[k].orientation + 1).collect();
        orientations.sort_unstable();
        orientations.dedup();
        let list: Vec<String> = orientations.iter().map(usize::to_string).collect();
        let (count, were) = (out.len(), plural(out.len(), "was", "were"));
        let (in_orientations, list) = (plural(list.len(), "orientation", "orientations"), list.join(", "));
        Code::Outliers
            .said(format!("{count} of {readings} {were} given no weight, in {in_orientations} {list}"))
    }))
}

/// The orientations would do, the readings do not belong to them.
fn misfit(problem: &AxesProblem<'_>, residuals_nt: &[f64]) -> String {
    let observations = problem.observations;
    let rms = |orientation: usize| {
        let all = observations.readings.iter().zip(residuals_nt);
        let own = all.filter(|(reading, _)| reading.orientation == orientation);
        let (sum, count) = own.fold((0.0, 0.0), |(sum, count), (_, e)| (sum + e * e, count + 1.0));
        (sum / f64::max(count, 1.0)).sqrt()
    };
    let worst = (0..observations.orientations.len()).max_by(|a, b| rms(*a).total_cmp(&rms(*b))).unwrap_or(0);
    format!(
        "the readings do not fit the model: they scatter by {} nT where the coils produce {} nT, most in \
         orientation {} (\"{}\", {} nT rms). An orientation may be wrong, transposed or with the wrong recording, or a constant, a frequency or a column may be wrong; --robust and --free-scales may show which",
        significant(problem.mean_std_nt(), 3),
        significant(observations.largest_drive_nt(), 4),
        worst + 1,
        observations.orientations[worst].recordings[0],
        significant(rms(worst), 3)
    )
}
