//! What noise with memory makes of the uncertainty of a stream's calibration.
//!
//! Rows are whitened window by window, noise with memory standing still in each, and forms of noise averaged
//! by restricted likelihood as for rows at hand ([`crate::noise`]). What such noise does within a window is
//! not seen; it shows in how the windows' calibrations scatter. The covariance is therefore widened,
//! parameter by parameter, to that of leaving out each window in turn where this is the larger.
//!
//! Source: for leaving out clusters, R. M. Bell, D. F. McCaffrey, Bias reduction in standard errors for
//! linear regression with multi-stage samples, Surv. Methodol. 28 (2002) 169–181.

use common::Noise;
use estimate::Svd;
use faer::{Col, ColRef, Mat};

use crate::Error;
use crate::fit::{FittedState, PriorRows};
use crate::kalman::{Form, WHITE};
use crate::linear::{Linear, RANK_TOLERANCE, root};
use crate::noise::{Groups, heaviest, mixture};

/// Fewer windows than these do not show a scatter.
const FEWEST: usize = 8;

/// Where noise takes more than this share of what is seen of a parameter, memory is not looked for: what it
/// adds to the products looks like it.
const NOISE_TAKES: f64 = 0.1;

/// Moves a fit of white noise by what the forms of noise with memory move it, and widens its covariance.
/// Gives the heaviest form with its noise, nT; None where memory cannot be looked for.
///
/// What noise adds to the products is taken off the fit of white noise alone, and its covariance holds it:
/// forms move both as they move those of the products as they are.
///
/// # Errors
///
/// [`Error::Fit`] where a decomposition fails.
pub fn widen(
    groups: &Groups,
    found: &mut FittedState,
    (held, known): (&PriorRows, &PriorRows),
    (declared, magnitude_nt): (Option<Form>, f64),
) -> Result<Option<(Form, Noise)>, Error> {
    let Some(filtered) = groups.weighed(held, (declared.unwrap_or(WHITE), declared.is_none())) else {
        return Ok(None);
    };
    let Some(white) = groups.linear(WHITE, found.variance, true) else { return Ok(None) };
    let heaviest = heaviest(&filtered);
    let all: PriorRows = held.iter().chain(known).cloned().collect();
    let count = found.state.len();
    let plain = Svd::of(white.with(&all, &found.state).jacobian.as_ref(), RANK_TOLERANCE)?.covariance();
    if (0..count).any(|k| plain[(k, k)] < (1.0 - NOISE_TAKES) * found.covariance[(k, k)]) {
        return Ok(None);
    }
    let scatter = groups
        .each_whitened(heaviest.form)
        .and_then(|windows| scatter(&windows, heaviest.variance, &all))
        .unwrap_or_else(|| vec![1.0; count]);
    let moved = |known: &PriorRows, own: &Mat<f64>, state: &[f64]| -> Result<_, Error> {
        let mixture = mixture(&filtered, known, state)?;
        let white = Svd::of(white.with(known, state).jacobian.as_ref(), RANK_TOLERANCE)?;
        let full = mixture.full && white.rank() == state.len();
        let turn = full.then(|| turn(own, &white.covariance())).flatten();
        Ok(turn.map(|turn| {
            let covariance = &turn * mixture.result().1 * turn.transpose();
            Mat::from_fn(state.len(), state.len(), |i, j| covariance[(i, j)] * scatter[i] * scatter[j])
        }))
    };
    let step = mixture(&filtered, &all, &found.state)?.result().0;
    let Linear { jacobian, right } = white.with(&all, &found.state);
    let before = Svd::of(jacobian.as_ref(), RANK_TOLERANCE)?.solve(&right);
    let alone = if found.seen.rank() == found.state.len() {
        moved(held, &found.seen.covariance(), &found.state)?
    } else {
        None
    };
    let Some(covariance) = moved(&all, &found.covariance, &found.state)? else { return Ok(None) };
    found
        .state
        .iter_mut()
        .zip(step.iter().zip(&before))
        .for_each(|(value, (step, white))| *value += step - white);
    found.covariance = covariance;
    if let Some(alone) = alone {
        found.jacobian = root(&alone);
        found.seen = Svd::of(found.jacobian.as_ref(), RANK_TOLERANCE)?;
    }
    Ok(Some((heaviest.form, heaviest.noise(magnitude_nt))))
}

/// T with T C Tᵀ another covariance: by Cholesky's factors of both.
fn turn(to: &Mat<f64>, from: &Mat<f64>) -> Option<Mat<f64>> {
    let size = |of: &Mat<f64>| (0..of.nrows()).map(|k| of[(k, k)].sqrt()).collect::<Vec<f64>>();
    let lengths = size(from);
    let even = |of: &Mat<f64>| {
        Mat::from_fn(of.nrows(), of.ncols(), |i, j| {
            0.5 * (of[(i, j)] + of[(j, i)]) / (lengths[i] * lengths[j])
        })
    };
    let (to, from) = (even(to).llt(faer::Side::Lower).ok()?, even(from).llt(faer::Side::Lower).ok()?);
    let (a, b) = (to.L(), from.L());
    // T Lb = La.
    let mut transposed = a.transpose().to_owned();
    b.transpose().solve_upper_triangular_in_place(&mut transposed);
    let count = lengths.len();
    Some(Mat::from_fn(count, count, |i, j| transposed[(j, i)] * lengths[i] / lengths[j]))
}

/// How many times as uncertain each parameter is by leaving out each window in turn, one at least; None for
/// few windows.
fn scatter(windows: &[Mat<f64>], variance: f64, known: &PriorRows) -> Option<Vec<f64>> {
    let windows: Vec<Linear> = windows.iter().map(|upper| Linear::of(upper, variance)).collect();
    if windows.len() < FEWEST {
        return None;
    }
    let count = windows[0].jacobian.ncols();
    let normal = |of: &Linear| of.jacobian.transpose() * &of.jacobian;
    let pull = |of: &Linear| of.jacobian.transpose() * ColRef::from_slice(&of.right);
    // What is known does not scatter.
    let fixed = Mat::from_fn(known.len(), count, |i, j| known[i].0[j]);
    let mut all = fixed.transpose() * &fixed;
    let mut total = Col::zeros(count);
    for one in &windows {
        all += normal(one);
        total += pull(one);
    }
    let solve = |matrix: &Mat<f64>, right: &Col<f64>| -> Option<Vec<f64>> {
        let lengths: Vec<f64> = (0..count).map(|k| matrix[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect();
        let even = Mat::from_fn(count, count, |i, j| matrix[(i, j)] / (lengths[i] * lengths[j]));
        let right: Vec<f64> = right.iter().zip(&lengths).map(|(value, length)| value / length).collect();
        let svd = Svd::of(even.as_ref(), 1e-13).ok().filter(|svd| svd.rank() == count)?;
        Some(svd.solve(&right).iter().zip(&lengths).map(|(value, length)| value / length).collect())
    };
    let best = solve(&all, &total)?;
    let mut squares = vec![0.0; count];
    for one in &windows {
        let rest = &all - normal(one);
        let without = solve(&rest, &(&total - pull(one)))?;
        squares.iter_mut().zip(without.iter().zip(&best)).for_each(|(sum, (a, b))| *sum += (a - b).powi(2));
    }
    let share = (windows.len() - 1) as f64 / windows.len() as f64;
    let own: Option<Vec<f64>> = (0..count)
        .map(|k| Some(solve(&all, &Col::from_fn(count, |j| if j == k { 1.0 } else { 0.0 }))?[k]))
        .collect();
    Some(squares.iter().zip(own?).map(|(sum, own)| (share * sum / own).sqrt().max(1.0)).collect())
}
