//! From readings to a solution with its uncertainty.

use common::Document;
use common::number::{counted, p_value, plural, significant};
use estimate::influence::{self, Influence};
use estimate::{Fit, Options as Iteration, Problem, robust, stats};
use faer::Mat;
use physics::frames::ARCSEC;

use crate::spread::{ReadingKind, Spread};
use crate::start::{self, Beginning};
use crate::unknowns::Unknown;
use crate::{
    AxesProblem, AxesState, Error, Freedom, NoiseFactors, NoiseSource, Observations, Options, freedom,
    priors, rank, readings,
};

/// A χ² less probable than this is not taken for chance: the uncertainties are then scaled to the residuals.
const CHI_SQUARED_P: f64 = 1e-3;
/// Singular values below this share of the largest are held still where the iteration wanders along them.
const COARSE_RANK: f64 = 1e-3;
/// A robust scale is not taken for the declared one beyond this over √(degrees of freedom): some four
/// standard deviations.
const ROBUST_EXCESS: f64 = 4.0;
/// A reading of less weight than this is left out.
const NO_WEIGHT: f64 = 1e-2;
/// A robust fit that leaves out a larger share than this is refused.
const MOST_REJECTED: f64 = 0.25;
/// Rounds in which noise and fit settle.
const ROUNDS: usize = 30;
/// Relative change of the noise at which it has settled: far below what is ever known of it.
const SETTLED: f64 = 1e-5;
/// Rounding of a reading, as a share of the largest.
const ROUNDING: f64 = 1e-13;
/// Noise of a fair reading, as a share of the drive: with it, a direction that is still unknown is so for its
/// orientations.
const GOOD_NOISE: f64 = 1e-4;
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
    /// Factors on the readings' standard deviations.
    pub noise: NoiseFactors,
    /// Where the standard deviations come from, in words.
    pub noise_source: String,
    /// χ² over the declared noise with its probability, where noise is declared.
    pub chi_squared: Option<(f64, f64)>,
    /// Degrees of freedom left.
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
    /// Weights of a robust fit.
    pub weights: Option<Vec<f64>>,
    /// Outliers: number, leave-one-out, t, adjusted p.
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
    let problem = AxesProblem::new(observations, &freedom, NoiseFactors::ONE);
    let plain = first_fit(&problem, start)?;
    let unseen = rank::unseen_turns(problem.meaning(), &plain.svd);
    if !unseen.is_empty() {
        return Err(Error::Unanswerable(rank::explain(&problem, &freedom, &plain.state, &unseen)));
    }
    let known_scale = observations.noise != NoiseSource::Residuals;
    let doubtful = readings::doubtful(&problem, &plain, known_scale)?;
    let steps = plain.steps.clone();
    let mut trusted = vec![1.0; problem.readings()];
    doubtful.iter().for_each(|doubt| trusted[doubt.reading] = 0.0);
    let (freedom, contradicted) = priors::settle(observations, freedom, &plain.state, &trusted, known_scale)?;
    findings.extend(contradicted);
    let problem = AxesProblem::new(observations, &freedom, NoiseFactors::ONE);

    let mut estimate = estimated(&problem, plain.state, known_scale, options)?;
    // Weighed-down residuals are no χ²; a robust fit judges the declared noise by its own scale.
    let chi_squared =
        (known_scale && !options.robust).then(|| (estimate.spread.sum_of_squares, estimate.spread.p()));
    let excess = 1.0 + ROBUST_EXCESS / estimate.spread.degrees_of_freedom.max(1.0).sqrt();
    let scattering: Vec<(ReadingKind, Spread)> =
        ReadingKind::of(observations, options.robust || !known_scale)
            .into_iter()
            .map(|kind| (kind, estimate.spread_of(observations, kind)))
            .filter(|(_, spread)| match chi_squared {
                Some(_) => {
                    spread.p() < CHI_SQUARED_P && spread.degrees_of_freedom >= 1.0 && spread.scale() > 1.0
                }
                None => !known_scale || estimate.scale > excess,
            })
            .collect();
    let mut noise = NoiseFactors::ONE;
    if !scattering.is_empty() {
        if estimate.spread.degrees_of_freedom < 0.5 {
            return Err(Error::Unanswerable(format!(
                "{} {} no degrees of freedom to estimate the noise; declare it in instrument.noise, or record more orientations",
                counted(problem.readings(), "reading"),
                plural(problem.readings(), "leaves", "leave")
            )));
        }
        // With priors the fit changes with the noise, and the noise with the fit: a few rounds settle it.
        let largest = observations.readings.iter().map(|r| r.value_nt.abs()).fold(0.0, f64::max);
        for _ in 0..ROUNDS {
            let before = noise;
            for (kind, _) in &scattering {
                let scale = if *kind == ReadingKind::All {
                    estimate.scale
                } else {
                    estimate.spread_of(observations, *kind).scale()
                };
                noise = kind.with(noise, (kind.factor(before) * scale).max(ROUNDING * largest));
            }
            let settled = scattering
                .iter()
                .all(|(kind, _)| (kind.factor(noise) / kind.factor(before) - 1.0).abs() < SETTLED);
            let problem = AxesProblem::new(observations, &freedom, noise);
            estimate = estimated(&problem, estimate.fit.state, false, options)?;
            if settled {
                break;
            }
        }
    }
    let problem = AxesProblem::new(observations, &freedom, noise);
    let freedoms =
        scattering.iter().map(|(kind, _)| estimate.spread_of(observations, *kind).degrees_of_freedom);
    let noise_freedom = freedoms.fold(f64::INFINITY, f64::min);
    let fit = if options.robust { unweighted(&problem, estimate.fit)? } else { estimate.fit };
    let residuals_nt = problem.residuals_nt(&fit.state);
    let covariance = fit.svd.covariance();
    check_certainty(&problem, &freedom, &fit.state, &covariance, &residuals_nt)?;
    if let Some(weights) = &estimate.weights {
        let noise_nt = mean_std_nt(&problem);
        findings.extend(rejected(observations, weights, &residuals_nt, noise_nt)?);
    }
    if known_scale {
        let told = scattering.iter().map(|(kind, spread)| {
            scatters(*kind, kind.factor(noise), chi_squared.is_some().then_some(spread))
        });
        findings.extend(told);
    }
    if let Some((sum, _)) = chi_squared.filter(|(_, p)| 1.0 - p < CHI_SQUARED_P)
        && scattering.is_empty()
        && observations.noise == NoiseSource::Declared
    {
        findings.push(format!(
            "the readings scatter only {} times as much as declared; the declared noise may be too large",
            significant((sum / estimate.spread.degrees_of_freedom).sqrt(), 3)
        ));
    }
    let noise_source = noise_source(observations.noise, known_scale, &scattering);
    Ok(Solution {
        meaning: problem.meaning().to_vec(),
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
fn first_fit(problem: &AxesProblem<'_>, start: AxesState) -> Result<Fit<AxesState>, Error> {
    match estimate::solve(problem, start.clone(), None, &Iteration::default()) {
        Err(estimate::Error::NotConverged { .. }) => {
            let coarse = Iteration { rank_tolerance: COARSE_RANK, ..Iteration::default() };
            Ok(estimate::solve(problem, start, None, &coarse)?)
        }
        result => Ok(result?),
    }
}

/// Where the standard deviations come from, kind by kind where only one of them was scaled.
fn noise_source(source: NoiseSource, known: bool, scattering: &[(ReadingKind, Spread)]) -> String {
    let own = match source {
        NoiseSource::Declared => "declared",
        NoiseSource::SineFits => "sine fits",
        NoiseSource::Residuals => "residuals",
    };
    match scattering {
        [] => own.into(),
        _ if !known => own.into(),
        [(ReadingKind::Constant, _)] => format!("{own}, that of constant drives scaled to the residuals"),
        [(ReadingKind::Ac, _)] => format!("{own}, that of AC runs scaled to the residuals"),
        _ => format!("{own}, scaled to the residuals"),
    }
}

fn scatters(kind: ReadingKind, factor: f64, spread: Option<&Spread>) -> String {
    let test = spread.map_or_else(String::new, |spread| {
        let freedom = counted(spread.degrees_of_freedom.round() as usize, "degree");
        format!(
            " (χ² = {} with {freedom} of freedom, {})",
            significant(spread.sum_of_squares, 3),
            p_value(spread.p())
        )
    });
    format!(
        "{} scatter {} times as much as declared{test}; their standard deviations are scaled up accordingly. --free-scales shows whether a constant is wrong, --robust the effect of outliers",
        kind.name(),
        significant(factor, 3)
    )
}

/// Mean standard deviation of a reading, nT.
fn mean_std_nt(problem: &AxesProblem<'_>) -> f64 {
    let readings = &problem.observations.readings;
    readings.iter().map(|reading| problem.std_nt(reading)).sum::<f64>() / readings.len() as f64
}

/// What a robust fit left out. A large share is no longer a matter of single readings.
fn rejected(
    observations: &Observations,
    weights: &[f64],
    residuals_nt: &[f64],
    noise_nt: f64,
) -> Result<Option<String>, Error> {
    let out: Vec<usize> = (0..weights.len()).filter(|k| weights[*k] < NO_WEIGHT).collect();
    if out.len() as f64 > MOST_REJECTED * weights.len() as f64 {
        let readings = &observations.readings;
        let drive = readings.iter().map(|reading| reading.drive_nt.amax()).fold(0.0, f64::max);
        return Err(Error::Unanswerable(format!(
            "{} of {} {} to another model than the rest. {}",
            out.len(),
            counted(weights.len(), "reading"),
            plural(out.len(), "belongs", "belong"),
            misfit(observations, residuals_nt, noise_nt, drive)
        )));
    }
    Ok((!out.is_empty()).then(|| {
        let mut orientations: Vec<usize> =
            out.iter().map(|&k| observations.readings[k].orientation + 1).collect();
        orientations.sort_unstable();
        orientations.dedup();
        let list: Vec<String> = orientations.iter().map(usize::to_string).collect();
        format!(
            "{} of {} {} given no weight, in {} {}",
            out.len(),
            counted(weights.len(), "reading"),
            plural(out.len(), "was", "were"),
            plural(list.len(), "orientation", "orientations"),
            list.join(", ")
        )
    }))
}

/// A fit with what it says of the noise.
struct Estimate {
    fit: Fit<AxesState>,
    weights: Option<Vec<f64>>,
    spread: Spread,
    /// Standard deviation of a reading, in units of the one that was put in.
    scale: f64,
}

impl Estimate {
    fn spread_of(&self, observations: &Observations, kind: ReadingKind) -> Spread {
        Spread::of(observations, &self.fit, self.weights.as_deref(), kind)
    }
}

/// A plain fit, or a robust one where it was asked for.
fn estimated(
    problem: &AxesProblem<'_>,
    start: AxesState,
    known_scale: bool,
    options: &Options,
) -> Result<Estimate, Error> {
    let (fit, weights, robust_scale) = if options.robust {
        let robust = robust::solve_robust(problem, start, known_scale, &Iteration::default())?;
        (robust.fit, Some(robust.weights), Some(robust.scale))
    } else {
        (estimate::solve(problem, start, None, &Iteration::default())?, None, None)
    };
    let spread = Spread::of(problem.observations, &fit, weights.as_deref(), ReadingKind::All);
    Ok(Estimate { scale: robust_scale.unwrap_or(spread.scale()), fit, weights, spread })
}

/// The problem with all readings alike at the minimum of a robust fit: the noise factor then makes its
/// covariance.
fn unweighted(problem: &AxesProblem<'_>, fit: Fit<AxesState>) -> Result<Fit<AxesState>, Error> {
    let (residual, jacobian) = estimate::linearised(problem, &fit.state);
    let svd = estimate::Svd::of(jacobian.as_ref(), Iteration::default().rank_tolerance)?;
    let cost = residual.iter().map(|r| r * r).sum();
    Ok(Fit { residual, jacobian, svd, cost, ..fit })
}

/// Directions whose uncertainty is beyond all use are refused: for want of turns where the orientations are
/// to blame, else because the readings do not fit.
fn check_certainty(
    problem: &AxesProblem<'_>,
    freedom: &Freedom,
    state: &AxesState,
    covariance: &Mat<f64>,
    residuals_nt: &[f64],
) -> Result<(), Error> {
    let turns: Vec<usize> = (0..problem.unknowns()).filter(|k| problem.meaning()[*k].is_turn()).collect();
    let worst = turns.iter().map(|&k| covariance[(k, k)]).fold(0.0, f64::max).sqrt();
    if worst <= LARGEST_STD {
        return Ok(());
    }
    let observations = problem.observations;
    let readings = &observations.readings;
    let drive = readings.iter().map(|reading| reading.drive_nt.amax()).fold(0.0, f64::max);
    let noise_nt = mean_std_nt(problem);
    if worst / noise_nt * GOOD_NOISE * drive <= LARGEST_STD {
        return Err(Error::Unanswerable(misfit(observations, residuals_nt, noise_nt, drive)));
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

/// The orientations would do, the readings do not belong to them.
fn misfit(observations: &Observations, residuals_nt: &[f64], noise_nt: f64, drive: f64) -> String {
    let rms = |orientation: usize| {
        let own =
            observations.readings.iter().zip(residuals_nt).filter(|(r, _)| r.orientation == orientation);
        let (sum, count) = own.fold((0.0, 0.0), |(sum, count), (_, e)| (sum + e * e, count + 1.0));
        (sum / f64::max(count, 1.0)).sqrt()
    };
    let worst = (0..observations.orientations.len()).max_by(|a, b| rms(*a).total_cmp(&rms(*b))).unwrap_or(0);
    format!(
        "the readings do not fit the model: they scatter by {} nT where the coils produce {} nT, most in \
         orientation {} (\"{}\", {} nT rms). An orientation may be wrong, transposed or with the wrong recording, or a constant, a frequency or a column may be wrong; --robust and --free-scales may show which",
        significant(noise_nt, 3),
        significant(drive, 4),
        worst + 1,
        observations.orientations[worst].recordings[0],
        significant(rms(worst), 3)
    )
}
