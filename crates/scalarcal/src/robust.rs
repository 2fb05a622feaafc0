//! Weights for rows that were disturbed: Tukey's bisquare of the residuals.

use estimate::robust::{bisquare, slope};
use estimate::stats::median_of;

use crate::Error;
use crate::design::Rows;
use crate::fit::{Found, Known, Sums, fit};
use crate::model::{Model, State};

/// Most rounds of reweighting.
const ROUNDS: usize = 30;
/// Weights that change by less are settled.
const SETTLED: f64 = 1e-6;
/// Standard deviation of normal numbers over the median of their sizes.
const NORMAL: f64 = 1.4826;

/// Refits with weights until they settle, and leaves the weights with the rows.
///
/// The covariance is that of least squares with the weights times Huber's factor, s² (Σψ²/(n − p))/(mean ψ′)² mean w over the weighted
/// variance, so that it covers where nothing is wrong (P. J. Huber, Robust Statistics, Wiley 1981, ch. 7).
pub fn fit_robust(
    model: &Model,
    rows: &mut Rows<'_>,
    (sensor, reference): (Option<f64>, f64),
    (held, known): (&Known, &Known),
    start: &State,
) -> Result<Found, Error> {
    let mut state = start.clone();
    let mut last = None;
    for _ in 0..ROUNDS {
        let residuals = rows.residuals(model, &state);
        let mut sizes: Vec<f64> = residuals.iter().flatten().map(|value| value.abs()).collect();
        let count = sizes.len() as f64;
        let scale = NORMAL * median_of(&mut sizes);
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
        let z = || residuals.iter().flatten().map(|value| value / scale);
        let psi: f64 = z().map(|z| (z * bisquare(z)).powi(2)).sum();
        let rise = z().map(slope).sum::<f64>() / count;
        let mean = weights.iter().flatten().sum::<f64>() / count;
        rows.weights = Some(weights);
        let plain = rows.factor(&model.terms);
        let sums = Sums { plain: &plain, sensor, reference, held };
        let mut found = fit(model, &sums, known, std::slice::from_ref(&state))?;
        let size = (scale / rows.scales.magnitude_nt).powi(2);
        let factor = size * (psi / found.freedom) / rise.max(0.1).powi(2) * mean / found.variance;
        found.covariance = &found.covariance * faer::Scale(factor);
        found.jacobian = &found.jacobian * faer::Scale(1.0 / factor.sqrt());
        found.variance *= factor;
        state.clone_from(&found.state);
        last = Some(found);
        if change < SETTLED {
            break;
        }
    }
    last.ok_or_else(|| {
        Error::Undetermined(
            "more than half of the residuals are zero; --robust has no scale to weigh by".into(),
        )
    })
}
