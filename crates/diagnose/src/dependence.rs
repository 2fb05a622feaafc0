//! Dependences on columns that no effect knows: the lag with which a sensor follows one.

use std::sync::Arc;

use crate::Error;
use crate::fit::{Fit, Fitter};
use crate::generic::following;
use crate::model::{Column, Follows};

/// Lags tried to either side of one that was found, and how far.
const STEPS: i32 = 24;
const FARTHEST: f64 = 4.0;

/// The same dependence with the lag of the largest gain, between the neighbours of the one that was found.
pub fn with_lag(fitter: &Fitter<'_, '_>, fit: &Fit, found: &Column) -> Result<Column, Error> {
    let Some(follows) = found.follows.as_ref().filter(|follows| follows.lag_s > 0.0) else {
        return Ok(found.clone());
    };
    let lag = |step: i32| follows.lag_s * FARTHEST.powf(f64::from(step) / f64::from(STEPS));
    let lags: Vec<f64> = (-STEPS..=STEPS).map(lag).collect();
    let columns: Vec<Vec<f64>> = lags
        .iter()
        .map(|lag_s| {
            following(fitter.model, follows.axis, &follows.column, *lag_s).dense(&fitter.model.observed)
        })
        .collect();
    let (screen, base) = fitter.screen_of(fit, &columns)?;
    let gains = (0..columns.len()).map(|k| screen.gain(&[base + k])).collect::<Result<Vec<_>, _>>()?;
    let Some(best) = (0..gains.len()).max_by(|a, b| gains[*a].gain.total_cmp(&gains[*b].gain)) else {
        return Ok(found.clone());
    };
    let scale = fit.cost / screen.freedom().max(1.0);
    let near =
        |k: &usize| gains[best].gain - gains[*k].gain < if fitter.noise.known > 0.0 { 1.0 } else { scale };
    let (first, last) =
        ((0..=best).find(near).unwrap_or(best), (best..gains.len()).rfind(near).unwrap_or(best));
    let inside = first > 0 && last + 1 < gains.len();
    let follows = Follows {
        lag_s: lags[best],
        lag_std_s: inside.then(|| 0.5 * (lags[last + 1] - lags[first - 1])),
        ..follows.clone()
    };
    Ok(Column {
        follows: Some(follows),
        values: Arc::new(columns[best].clone()),
        coefficient: gains[best].coefficients.first().copied().unwrap_or(found.coefficient),
        ..found.clone()
    })
}

/// nT per unit of a column, as a name.
pub fn coefficient(column: &str) -> String {
    format!("coefficient_nt_per_{}", common::unit::of_change(column))
}
