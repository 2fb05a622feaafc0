//! Whether a fit that has converged answers: directions known well enough, readings that fit.

use common::number::{counted, plural, significant};
use common::{Code, Finding};
use estimate::Problem;
use faer::Mat;
use physics::frames::ARCSEC;

use crate::unknowns::turns;
use crate::{AxesProblem, AxesState, Error, Freedom, Result, rank};

/// A reading of less weight than this is left out.
const NO_WEIGHT: f64 = 1e-2;
/// A robust fit that leaves out a larger share than this is refused.
const MOST_REJECTED: f64 = 0.25;
/// Noise of a fair reading, as a share of the drive: with it, a direction that is still unknown is so for its
/// orientations.
const GOOD_NOISE: f64 = 1e-4;
/// A direction that is known to no better than this is not known, rad.
const LARGEST_STD: f64 = 3600.0 * ARCSEC;

/// Directions whose uncertainty is beyond all use are refused: for want of turns where the orientations are
/// to blame, else because the readings do not fit.
pub fn check(
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
    if worst / mean_std_nt(problem) * GOOD_NOISE * problem.observations.largest_drive_nt() <= LARGEST_STD {
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
pub fn rejected(problem: &AxesProblem<'_>, weights: &[f64], residuals_nt: &[f64]) -> Result<Option<Finding>> {
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
        let own =
            observations.readings.iter().zip(residuals_nt).filter(|(r, _)| r.orientation == orientation);
        let (sum, count) = own.fold((0.0, 0.0), |(sum, count), (_, e)| (sum + e * e, count + 1.0));
        (sum / f64::max(count, 1.0)).sqrt()
    };
    let worst = (0..observations.orientations.len()).max_by(|a, b| rms(*a).total_cmp(&rms(*b))).unwrap_or(0);
    format!(
        "the readings do not fit the model: they scatter by {} nT where the coils produce {} nT, most in \
         orientation {} (\"{}\", {} nT rms). An orientation may be wrong, transposed or with the wrong recording, or a constant, a frequency or a column may be wrong; --robust and --free-scales may show which",
        significant(mean_std_nt(problem), 3),
        significant(observations.largest_drive_nt(), 4),
        worst + 1,
        observations.orientations[worst].recordings[0],
        significant(rms(worst), 3)
    )
}

/// Mean standard deviation of a reading, nT.
fn mean_std_nt(problem: &AxesProblem<'_>) -> f64 {
    let readings = &problem.observations.readings;
    readings.iter().map(|reading| problem.std_nt(reading)).sum::<f64>() / readings.len() as f64
}
