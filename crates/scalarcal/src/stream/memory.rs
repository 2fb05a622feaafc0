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
use estimate::positive::Positive;
use faer::{Col, ColRef, Mat};

use crate::Error;
use crate::fit::FittedState;
use crate::kalman::{Form, WHITE};
use crate::linear::{Linear, RANK_TOLERANCE, deviations, root};
use crate::noise::{Average, Groups, average, heaviest};

/// Fewer windows than these do not show a scatter.
const FEWEST: usize = 8;

/// Where noise takes more than this share of what is seen of a parameter, memory would not show.
const NOISE_TAKES: f64 = 0.1;

/// Moves a fit of white noise by what the forms of noise with memory move it, and widens its covariance.
/// Gives the heaviest form with its noise, nT; None where memory cannot be looked for.
///
/// What noise adds to the products is taken off the fit of white noise alone, and its covariance holds it:
/// forms move both as they move those of the products as they are.
///
/// Errors: [`Error::Fit`] where a decomposition fails.
pub fn widen(
    groups: &Groups,
    found: &mut FittedState,
    (held, known): (&Linear, &Linear),
    (base, searched, magnitude_nt): (Form, bool, f64),
) -> Result<Option<(Form, Noise)>, Error> {
    let Some(forms) = groups.weighed(held, (base, searched)) else { return Ok(None) };
    let Some(heaviest) = heaviest(&forms) else { return Ok(None) };
    let Some(white) = groups.linear(WHITE, found.variance, true) else { return Ok(None) };
    let count = found.state.len();
    let together = white.and(&known.about(&found.state));
    let plain = together.svd()?;
    let (before, covariance) = (plain.solve(&together.right), plain.covariance());
    if (0..count).any(|k| covariance[(k, k)] < (1.0 - NOISE_TAKES) * found.covariance[(k, k)]) {
        return Ok(None);
    }
    let scatter = groups
        .each_whitened(heaviest.form)
        .and_then(|windows| scatter(&windows, heaviest.variance, known))
        .unwrap_or_else(|| vec![1.0; count]);
    let joint = average(&forms, known, &found.state)?;
    let moved = |average: &Average, white: &Svd, own: &Mat<f64>| -> Option<Mat<f64>> {
        let full = average.full && white.rank() == count;
        let turn = full.then(|| turn(own, &white.covariance())).flatten()?;
        let covariance = &turn * &average.covariance * turn.transpose();
        Some(Mat::from_fn(count, count, |i, j| covariance[(i, j)] * scatter[i] * scatter[j]))
    };
    let alone = if found.seen.rank() == count {
        let alone = average(&forms, held, &found.state)?;
        moved(&alone, &white.and(held).svd()?, &found.seen.covariance())
    } else {
        None
    };
    let Some(covariance) = moved(&joint, &plain, &found.covariance) else { return Ok(None) };
    for ((value, step), before) in found.state.iter_mut().zip(&joint.step).zip(&before) {
        *value += step - before;
    }
    found.covariance = covariance;
    if let Some(alone) = alone {
        found.jacobian = root(&alone);
        found.seen = Svd::of(found.jacobian.as_ref(), RANK_TOLERANCE)?;
    }
    Ok(Some((heaviest.form, heaviest.noise(magnitude_nt))))
}

/// T with T C Tᵀ another covariance: by Cholesky's factors of both.
fn turn(to: &Mat<f64>, from: &Mat<f64>) -> Option<Mat<f64>> {
    let lengths = deviations(from);
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

/// How much more uncertain each parameter is by leaving out windows in turn, 1 at least; None for few.
fn scatter(windows: &[Mat<f64>], variance: f64, known: &Linear) -> Option<Vec<f64>> {
    if windows.len() < FEWEST {
        return None;
    }
    let windows: Vec<Linear> = windows.iter().map(|upper| Linear::of(upper, variance)).collect();
    let count = known.jacobian.ncols();
    let normal = |of: &Linear| of.jacobian.transpose() * &of.jacobian;
    let pull = |of: &Linear| of.jacobian.transpose() * ColRef::from_slice(&of.right);
    // What is known does not scatter.
    let (mut all, mut total) = (normal(known), Col::zeros(count));
    for one in &windows {
        all += normal(one);
        total += pull(one);
    }
    let inverse = |matrix: &Mat<f64>| Some(Positive::of(matrix).ok()?.inverse);
    let whole = inverse(&all)?;
    let best = &whole * &total;
    let mut squares = vec![0.0; count];
    for one in &windows {
        let off = inverse(&(&all - normal(one)))? * (&total - pull(one)) - &best;
        squares.iter_mut().zip(off.iter()).for_each(|(sum, off)| *sum += off * off);
    }
    let share = (windows.len() - 1) as f64 / windows.len() as f64;
    let times = |(k, sum): (usize, &f64)| (share * sum / whole[(k, k)]).sqrt().max(1.0);
    Some(squares.iter().enumerate().map(times).collect())
}
