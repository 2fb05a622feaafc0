//! Columns that are not fitted: their sizes are held.

use estimate::cosine::{Errors, Projection};
use estimate::dot;
use estimate::spectral::SpectralFit;
use faer::Mat;

use crate::Error;
use crate::drift::Columns;

/// The steps of which the band says more, beside the other columns and each other, than the search that found
/// them: these are fitted, the others keep the sizes that were found. So steps that lie too close for the
/// band are not told apart by it.
pub fn determined(
    columns: &Columns<'_>,
    steps: &[Vec<f64>],
    stds: &[f64],
    errors: &Errors,
) -> Result<Vec<usize>, Error> {
    let transforms: Vec<Vec<f64>> = steps.iter().map(|step| columns.transform(step)).collect();
    let mut fitted: Vec<usize> = Vec::new();
    for (number, (transform, std)) in transforms.iter().zip(stds).enumerate() {
        let mut beside = columns.base();
        beside.extend(fitted.iter().map(|step| transforms[*step].as_slice()));
        let Some(direction) = Projection::of(&beside, transform, errors)?.direction(transform, errors) else {
            continue;
        };
        let information = dot(&direction, &errors.whiten(transform));
        if information * std >= 1.0 {
            fitted.push(number);
        }
    }
    Ok(fitted)
}

/// Where a column stands in a fit.
#[derive(Clone, Copy)]
pub enum Place {
    Fitted(usize),
    /// Nowhere: nothing is to be added to what was taken off, with this standard uncertainty.
    Held(f64),
}

impl Place {
    /// The value of this column among those that were fitted.
    pub fn of(self, fitted: &[f64]) -> f64 {
        match self {
            Place::Fitted(at) => fitted[at],
            Place::Held(_) => 0.0,
        }
    }

    /// The same where one of the columns is not fitted but held at nothing.
    pub fn without(self, column: usize) -> Self {
        match self {
            Place::Fitted(at) if at == column => Place::Held(0.0),
            Place::Fitted(at) if at > column => Place::Fitted(at - 1),
            other => other,
        }
    }
}

/// A fit with the columns that were not fitted in their places.
pub fn with_held(fit: SpectralFit, places: &[Place]) -> SpectralFit {
    let values = |own: &[f64]| -> Vec<f64> { places.iter().map(|place| place.of(own)).collect() };
    let matrix = |own: &Mat<f64>| {
        Mat::from_fn(places.len(), places.len(), |i, j| match (places[i], places[j]) {
            (Place::Fitted(a), Place::Fitted(b)) => own[(a, b)],
            (Place::Held(std), Place::Held(_)) if i == j => std * std,
            _ => 0.0,
        })
    };
    SpectralFit {
        least_squares: values(&fit.least_squares),
        covariance: matrix(&fit.covariance),
        independent: matrix(&fit.independent),
        weighted: values(&fit.weighted),
        weighted_covariance: matrix(&fit.weighted_covariance),
    }
}
