//! From readings to a solution with its uncertainty.

use common::{Axis, Document};
use estimate::influence::Influence;
use estimate::{Fit, Options as Iteration, Problem, robust, stats};
use faer::Mat;
use nalgebra::{DMatrix, Vector3};
use physics::frames::{ARCSEC, tangents};

use crate::model::{KnownCoils, Unknown};
use crate::observations::{relative_std, std_of};
use crate::start::{self, Beginning};
use crate::{AxesProblem, AxesState, Coils, Error, Freedom, Observations, Options, rank, readings};

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
    let freedom = freedom(document, observations, options)?;
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

/// What may move, from what the document states and what the drives can show.
fn freedom(document: &Document, observations: &Observations, options: &Options) -> Result<Freedom, Error> {
    let empty = common::Calibration::default();
    let calibration = document.calibration.as_ref().unwrap_or(&empty);
    let mut freedom = Freedom {
        known_coils: known_coils(calibration, observations, options)?,
        orientations: observations
            .orientations
            .iter()
            .any(|group| group.orientation.uncertainty.norm() > 0.0),
        ..Freedom::default()
    };
    let constants_show = separates_constants(observations);
    let facility = document.facility.as_ref().and_then(|facility| facility.residual_field_std_nt);
    let mut residual_variance = facility.map_or(0.0, |std| std * std);
    for axis in Axis::ALL {
        let i = axis.index();
        let sensor = calibration.sensors.as_ref().and_then(|sensors| sensors.get(axis));
        let coil = calibration.coils.as_ref().and_then(|coils| coils.get(axis));
        let sensitivity =
            sensor.and_then(|s| s.sensitivity_nt_per_v.as_ref().or(s.sensitivity_nt_per_nt.as_ref()));
        let offset = sensor
            .and_then(|s| s.offset_nt.as_ref())
            .and_then(|offset| offset.std())
            .filter(|std| *std > 0.0);
        freedom.sensor_scale[i] =
            if options.free_scales { Some(f64::INFINITY) } else { relative_std(sensitivity) };
        freedom.coil_scale[i] = if options.free_scales {
            Some(f64::INFINITY)
        } else {
            relative_std(coil.and_then(|coil| coil.constant_nt_per_a.as_ref()))
        };
        freedom.offsets[i] = if constants_show { Some(offset.unwrap_or(f64::INFINITY)) } else { offset };
        let coil_offset = coil.and_then(|coil| coil.offset_nt.as_ref()).and_then(|offset| offset.std());
        residual_variance += coil_offset.unwrap_or(0.0).powi(2) / 3.0;
    }
    freedom.residual_field = if constants_show {
        Some(f64::INFINITY)
    } else {
        Some(residual_variance.sqrt()).filter(|std| *std > 0.0)
    };
    Ok(freedom)
}

/// Whether in some orientation the drives tell a constant from a field in proportion to the drive: zero or
/// reversed drives were recorded. The rows (B_c, 1) then have one rank more than the coils driven.
pub(crate) fn separates_constants(observations: &Observations) -> bool {
    let largest = observations.readings.iter().map(|reading| reading.drive_nt.amax()).fold(0.0, f64::max);
    (0..observations.orientations.len()).any(|orientation| {
        let rows: Vec<[f64; 4]> = observations
            .readings
            .iter()
            .filter(|r| r.orientation == orientation && r.constant && r.sensor == observations.sensors[0])
            .map(|r| [r.drive_nt[0] / largest, r.drive_nt[1] / largest, r.drive_nt[2] / largest, 1.0])
            .collect();
        let rank = |columns: usize| {
            let matrix =
                Mat::from_fn(rows.len(), columns, |i, j| rows[i][if columns == 3 { j } else { (j + 3) % 4 }]);
            estimate::Svd::of(matrix.as_ref(), 1e-3).map_or(0, |svd| svd.rank())
        };
        !rows.is_empty() && rank(4) > rank(3)
    })
}

/// The coils as `calibration.axes.coils` gives them, where they are to be taken as known.
fn known_coils(
    calibration: &common::Calibration,
    observations: &Observations,
    options: &Options,
) -> Result<Option<KnownCoils>, Error> {
    if options.coils == Coils::Unknown {
        return Ok(None);
    }
    let Some(given) = calibration.axes.as_ref().and_then(|axes| axes.coils.as_ref()) else { return Ok(None) };
    let Some(matrix) = given.matrix else { return Ok(None) };
    let matrix = physics::frames::matrix(&matrix);
    let directions = [0, 1, 2].map(|j| matrix.column(j).normalize());
    let coils = &observations.coils;
    // T maps turns along the tangents to changes of the matrix, column by column.
    let mut covariance = DMatrix::zeros(2 * coils.len(), 2 * coils.len());
    match &given.covariance {
        Some(full) if full.len() == 9 && full.iter().all(|row| row.len() == 9) => {
            let tangent = |n: usize, k: usize| -> (usize, Vector3<f64>) {
                let j = coils[n].index();
                (3 * j, tangents(&directions[j])[k])
            };
            for a in 0..2 * coils.len() {
                for b in 0..2 * coils.len() {
                    let ((first, left), (second, right)) = (tangent(a / 2, a % 2), tangent(b / 2, b % 2));
                    covariance[(a, b)] = (0..9)
                        .map(|k| left[k / 3] * full[first + k / 3][second + k % 3] * right[k % 3])
                        .sum();
                }
            }
        }
        Some(_) => {
            return Err(common::Error::document(
                "calibration.axes.coils.covariance",
                "a matrix that is not 9x9",
                "9x9, over the elements of `matrix` column by column, as covariance_order says",
            )
            .into());
        }
        None => {
            for (n, &axis) in coils.iter().enumerate() {
                let std = std_of(given.std_arcsec.as_ref(), axis).unwrap_or(0.0) * ARCSEC;
                covariance[(2 * n, 2 * n)] = std * std;
                covariance[(2 * n + 1, 2 * n + 1)] = std * std;
            }
        }
    }
    if covariance.iter().all(|element| *element == 0.0) {
        return Ok(Some(KnownCoils { directions, whitening: None }));
    }
    let inverse_root = covariance.clone().cholesky().and_then(|root| root.l().try_inverse()).ok_or_else(|| {
        common::Error::document(
            "calibration.axes.coils",
            "an uncertainty that is zero for one direction and not for another, or a covariance that is not positive",
            "a covariance, or std_arcsec, that is positive for every coil that is driven",
        )
    })?;
    Ok(Some(KnownCoils { directions, whitening: Some(inverse_root) }))
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
