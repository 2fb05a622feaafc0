//! Rows that were disturbed: those to which Tukey's bisquare gives no weight.

use estimate::robust::{bisquare, scale_of};

use crate::Error;
use crate::declared::Given;
use crate::design::Rows;
use crate::fitted::Fitted;

/// Most rounds of reweighting.
const ROUNDS: usize = 30;
/// Weights that change by less are settled.
const SETTLED: f64 = 1e-6;

/// Which rows of each recording count, after fits with weights until these settle. Of normal errors one in
/// 350 000 is left out, so that the fit of the others is that of least squares.
///
/// # Errors
///
/// [`Error::Unanswerable`] where more than half of the residuals are zero.
pub fn kept(given: &Given<'_>, fitted: &Fitted, rows: &mut Rows<'_>) -> Result<Vec<Vec<bool>>, Error> {
    let mut state = fitted.found.state.clone();
    for _ in 0..ROUNDS {
        let residuals = rows.residuals(&fitted.model, &state);
        let mut sizes: Vec<f64> = residuals.iter().flatten().map(|value| value.abs()).collect();
        let scale = scale_of(&mut sizes);
        if scale <= 0.0 || scale.is_nan() {
            break;
        }
        let weights: Vec<Vec<f64>> = residuals
            .iter()
            .map(|values| values.iter().map(|value| bisquare(value / scale)).collect())
            .collect();
        let change = match &rows.weights {
            Some(before) => {
                let pairs = before.iter().flatten().zip(weights.iter().flatten());
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            }
            None => f64::INFINITY,
        };
        rows.weights = Some(weights);
        if change < SETTLED {
            break;
        }
        let plain = rows.factor(&fitted.model.terms);
        state = fitted.again(given, &plain, &state)?.state;
    }
    let weights = rows.weights.take().ok_or_else(|| {
        Error::Unanswerable(
            "more than half of the residuals are zero; --robust cannot estimate a scale".into(),
        )
    })?;
    Ok(weights.iter().map(|weights| weights.iter().map(|weight| *weight > 0.0).collect()).collect())
}
