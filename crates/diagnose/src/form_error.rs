//! What departures from their equations add to the uncertainty of all that is fitted.
//!
//! The fit has each effect exactly as its equation has it. Departures are shares of what the effect does
//! beside the calibration. With J the whitened derivatives of the fit's unknowns, C their covariance and F
//! the departures, each of prior standard deviation ψ, what the residual w says of the departures is
//!
//! ```text
//! c = K Fᵀw,  K = (Fᵀ(1 − JCJᵀ)F + ψ⁻²)⁻¹
//! ```
//!
//! The fit is biased by CJᵀF times the true departures, whose mean square is K + ccᵀ; the covariance of that
//! bias is added to C.

use estimate::dot;
use faer::{ColRef, Mat};
use nalgebra::{DMatrix, DVector};
use physics::Role;
use rayon::prelude::*;

use crate::Error;
use crate::additions::without;
use crate::algebra::{columns as columns_of, inverse, left, orthonormal, square};
use crate::decide::FORM;
use crate::fit::Fit;
use crate::form::{Followed, orders};
use crate::model::{Model, State, amplitudes};
use crate::proposal::Addition;
use crate::stacked::Stacked;
use crate::whitening::NoiseModel;

/// From one time constant of a mixture to the next.
const APART: f64 = 2.5;

/// What comes on top of the covariance of a fit whose effects, from a number on in the order of these
/// additions, may depart from their equations by these shares, group by group.
pub fn added<'n>(
    model: &Model<'_>,
    (fit, noise): (&Fit, &NoiseModel),
    from: usize,
    names: impl Iterator<Item = (&'n [Addition], &'n [f64])>,
) -> Result<Mat<f64>, Error> {
    let followed = Followed::of(model, &fit.state)?;
    let base = model.base_columns(&fit.state)?;
    let design = fit.jacobian.submatrix(0, 0, model.observed.rows, base.len());
    let inverse = inverse(design)?;
    // The part that the calibration cannot absorb, so that an effect's reference temperature makes no
    // difference.
    let seen = |mut own: Vec<f64>| -> Result<Vec<f64>, Error> {
        let white = noise.whiten(&model.observed, &own);
        let along = &inverse * (design.transpose() * ColRef::from_slice(&white));
        for (column, along) in base.iter().zip(along.iter()) {
            own.iter_mut().zip(column).for_each(|(own, base)| *own -= along * base);
        }
        Ok(own)
    };
    let mut columns: Vec<Stacked> = Vec::new();
    let mut shares: Vec<f64> = Vec::new();
    let mut number = from;
    for (additions, departs) in names {
        for addition in additions {
            let Addition::Effect(_) = addition else { continue };
            let effect = &fit.state.effects[number];
            let most = departs.iter().copied().fold(0.0, f64::max);
            if most > 0.0 {
                let (without, _) = without(&fit.state, (number, 0), std::slice::from_ref(addition));
                let own = seen(model.change(&without, &fit.state)?)?;
                let energy = square(&noise.whiten(&model.observed, &own));
                let own = Stacked::of(&model.observed, &own);
                let groups = followed.departures(effect, &own, orders(energy));
                for (group, columns_of_group) in groups.into_iter().enumerate() {
                    let share = departs.get(group).copied().unwrap_or(most);
                    shares.extend(std::iter::repeat_n(share, columns_of_group.len()));
                    columns.extend(columns_of_group);
                }
            }
            for other in mixture(fit, number) {
                let column = model.change(&fit.state, &other)?;
                shares.push(FORM[FORM.len() - 1]);
                columns.push(Stacked::of(&model.observed, &column));
            }
            number += 1;
        }
    }
    if columns.is_empty() {
        return Ok(Mat::zeros(fit.covariance.nrows(), fit.covariance.ncols()));
    }
    let dense: Vec<Vec<f64>> = columns.iter().map(|column| column.dense(&model.observed)).collect();
    beyond(fit, &noise.whiten_all(&model.observed, &dense), &shares)
}

/// The state with an effect's time constant longer and shorter: a real relaxation is a mixture of several.
fn mixture(fit: &Fit, number: usize) -> Vec<State> {
    let effect = &fit.state.effects[number];
    let infos = effect.kind.parameters();
    let constant = infos.iter().position(|info| info.role == Role::Shape && info.name.ends_with("_s"));
    let sized = !amplitudes(effect.kind).is_empty();
    let Some(constant) = constant.filter(|_| sized) else { return Vec::new() };
    let with = |factor: f64| {
        let mut state = fit.state.clone();
        state.effects[number].parameters[constant] *= factor;
        state
    };
    vec![with(APART), with(1.0 / APART)]
}

/// What whitened departures of these standard deviations beforehand add to the covariance of a fit.
fn beyond(fit: &Fit, departures: &[Vec<f64>], deviations: &[f64]) -> Result<Mat<f64>, Error> {
    let (unknowns, count) = (fit.jacobian.ncols(), departures.len());
    // What nothing determines takes no part in it.
    let known = |k: usize| fit.covariance[(k, k)].is_finite();
    let covariance = |i: usize, j: usize| if known(i) && known(j) { fit.covariance[(i, j)] } else { 0.0 };
    let covariance = DMatrix::from_fn(unknowns, unknowns, covariance);
    let scaled = departures.iter().zip(deviations);
    let scaled: Vec<Vec<f64>> =
        scaled.map(|(column, std)| column.iter().map(|value| value * std).collect()).collect();
    let along = DMatrix::from_fn(unknowns, count, |i, j| dot(fit.jacobian.col_as_slice(i), &scaled[j]));
    let moved = &covariance * &along;
    let basis = orthonormal(&fit.jacobian)?;
    let beside: Vec<Vec<f64>> = scaled.par_iter().map(|column| left(columns_of(&basis), column)).collect();
    let own = DMatrix::from_fn(count, count, |i, j| dot(&beside[i], &beside[j]));
    let Some(factor) = (DMatrix::identity(count, count) + own).cholesky() else {
        return Err(Error::Unanswerable("what the effects' forms leave is not finite".into()));
    };
    let mean = factor.solve(&DVector::from_fn(count, |j, _| dot(&beside[j], &fit.white)));
    // Of roots, so that rounding leaves no negative variance.
    let Some(spread) = factor.l().solve_lower_triangular(&moved.transpose()) else {
        return Err(Error::Unanswerable("what the effects' forms leave is not finite".into()));
    };
    let biased = &moved * mean;
    let added = spread.transpose() * &spread + &biased * biased.transpose();
    Ok(Mat::from_fn(unknowns, unknowns, |i, j| added[(i, j)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line through the origin whose rows may curve: the variance of its slope by hand.
    #[test]
    fn a_departure_adds_the_variance_of_the_bias_that_it_makes() {
        let rows = 40;
        let x = |i: usize| (i as f64 + 0.5) / rows as f64;
        let jacobian = Mat::from_fn(rows, 1, |i, _| x(i));
        let curve: Vec<f64> = (0..rows).map(|i| x(i) * (2.0 * x(i) - 1.0)).collect();
        let energy: f64 = (0..rows).map(|i| x(i) * x(i)).sum();
        let std = 3.0;
        // The residual is zero, so that the posterior mean of the curve is zero too.
        let fit = Fit {
            state: State::default(),
            residual: vec![0.0; rows],
            white: vec![0.0; rows],
            covariance: Mat::from_fn(1, 1, |_, _| 1.0 / energy),
            jacobian: jacobian.into(),
            beyond: Mat::zeros(1, 1),
            rank: 1,
            cost: 0.0,
        };
        let added = beyond(&fit, std::slice::from_ref(&curve), &[std]).expect("determined");
        let found = fit.widened(&added).covariance[(0, 0)];
        let across: f64 = (0..rows).map(|i| x(i) * curve[i]).sum();
        let left: f64 = curve.iter().map(|c| c * c).sum::<f64>() - across * across / energy;
        let expected = 1.0 / energy + (across / energy).powi(2) / (left + 1.0 / (std * std));
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} for {expected}");
    }
}
