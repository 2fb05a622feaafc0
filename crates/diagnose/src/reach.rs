//! How far the constants of the sensors may be from where the calibration has them, as far as magnitudes
//! tell.
//!
//! A field that points one way tells of nine constants a level and three slopes; along all else a fit to
//! magnitudes goes where noise takes it. So each constant is known beforehand: a sensitivity k within ±s k, a
//! turn within ±s rad, an offset, about its part in the level of the difference as it came, within the
//! scatter of that and ±s of the field; each together with the uncertainty that the calibration states of it.
//! The share s is the one with which the readings are likeliest, all constants integrated out:
//!
//! ln p(y | s) = −½ (χ² + Σ (β/σ)² + ln det C + Σ ln σ² + ln det(JᵀC⁻¹J + Σ⁻¹)),
//!
//! β the shifts, σ their standard uncertainties beforehand, C the covariance of the noise, with each s as it
//! is declared or as the fit leaves it. Where the best s is not twenty times likelier than none, it is none:
//! slopes that noise with memory explains nearly as well are not fitted.
//!
//! Source: D. J. C. MacKay, Bayesian interpolation, Neural Computation 4 (1992) 415–447.

use common::Document;
use faer::Mat;

use crate::Error;
use crate::algebra::square;
use crate::fit::{Fit, settled};
use crate::model::{Model, State};
use crate::whitening::NoiseModel;

/// The shares that are tried, from none on.
const SHARES: [f64; 10] = [1e-7, 1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1.0];
/// The constants stay where they are unless the best share is likelier than none by more: odds of twenty.
const AS_LIKELY: f64 = 3.0;
/// A constant is determined where recordings leave less than this share of what was known of it.
const DETERMINED: f64 = 0.5;
/// Eigenvalues of products of columns of length one below this are rounding.
const ROUNDING: f64 = 1e-14;

/// The fit and the noise it rests on, the constants within reach of the calibration where only magnitudes
/// were recorded.
pub fn within(document: &Document, model: &mut Model<'_>, start: &State) -> Result<(Fit, NoiseModel), Error> {
    if !model.only_magnitudes() {
        return settled(document, model, start);
    }
    let came = model.residual(start)?;
    let mut tried: Vec<(f64, f64, State)> = Vec::new();
    let mut best = 0;
    // From the least on: what is far is found from what is near.
    for share in SHARES {
        model.hold(document, share, &came);
        let from = tried.get(best).map_or(start, |(.., state)| state);
        let (fit, noise) = settled(document, model, from)?;
        let likely = likely(model, &fit, &noise)?;
        if tried.get(best).is_some_and(|(most, ..)| likely > *most) {
            best = tried.len();
        }
        tried.push((likely, share, fit.state));
    }
    let stands = &tried[if tried[best].0 - tried[0].0 < AS_LIKELY { 0 } else { best }];
    model.hold(document, stands.1, &came);
    settled(document, model, &stands.2)
}

/// ln p(y | s) up to a constant.
fn likely(model: &Model<'_>, fit: &Fit, noise: &NoiseModel) -> Result<f64, Error> {
    let rows = fit.residual.len();
    let beforehand: f64 = model.priors.iter().flatten().map(|std| 2.0 * std.ln()).sum();
    let occam = square(&fit.white[rows..]) + beforehand + log_determinant(&fit.jacobian)?;
    Ok(fit.log_likelihood(noise) - 0.5 * occam)
}

/// ln det JᵀJ.
fn log_determinant(jacobian: &Mat<f64>) -> Result<f64, Error> {
    let count = jacobian.ncols();
    let squares: Vec<f64> = (0..count).map(|k| square(jacobian.col_as_slice(k))).collect();
    let scaled = Mat::from_fn(jacobian.nrows(), count, |i, k| jacobian[(i, k)] / squares[k].sqrt());
    let eigen = (scaled.transpose() * &scaled).self_adjoint_eigen(faer::Side::Lower).map_err(|error| {
        let reason = format!("{error:?}");
        estimate::Error::Decomposition { rows: count, columns: count, reason }
    })?;
    let values = (0..count).map(|k| eigen.S().column_vector()[k].max(ROUNDING).ln());
    Ok(values.sum::<f64>() + squares.iter().map(|square| square.ln()).sum::<f64>())
}

/// The unknowns that a fit to magnitudes leaves at what is known of them.
pub fn undetermined(model: &Model<'_>, fit: &Fit) -> Vec<usize> {
    if !model.only_magnitudes() {
        return Vec::new();
    }
    let left =
        |k: &usize| model.priors[*k].is_some_and(|std| fit.covariance[(*k, *k)].sqrt() > DETERMINED * std);
    (0..model.unknowns.len()).filter(left).collect()
}
