//! Iteratively reweighted least squares with Tukey's bisquare.

use crate::gauss_newton::{Fit, Options, Problem, solve};
use crate::{Error, stats};

/// Tuning constant of the bisquare: 95 % efficiency for normal errors.
const TUNING: f64 = 4.685;
/// Median of |z| for a standard normal z.
const MEDIAN_ABSOLUTE_NORMAL: f64 = 0.674_489_75;

/// Fits with readings far from the rest weighed down; gives the fit and the weights, 0 to 1.
///
/// The scale is the median absolute residual, corrected for leverage, or `known_scale` standard
/// deviations where those are declared and the residuals agree.
pub fn solve_robust<P: Problem>(
    problem: &P,
    start: P::State,
    known_scale: bool,
    options: &Options,
) -> Result<(Fit<P::State>, Vec<f64>), Error> {
    let readings = problem.readings();
    let mut weights = vec![1.0; readings];
    let mut fit = solve(problem, start, None, options)?;
    for _ in 0..50 {
        let (mut residual, mut jacobian) = (vec![0.0; problem.rows()], fit.jacobian.clone());
        jacobian.fill(0.0);
        problem.linearise(&fit.state, &mut residual, jacobian.as_mut());
        let leverage = fit.svd.leverage();
        let standardised: Vec<f64> = (0..readings)
            .map(|i| residual[i] / (1.0 - weights[i] * leverage[i].min(1.0)).max(1e-9).sqrt())
            .collect();
        let absolute: Vec<f64> = standardised.iter().map(|r| r.abs()).collect();
        let mut scale = stats::median(&absolute) / MEDIAN_ABSOLUTE_NORMAL;
        if known_scale {
            scale = scale.max(1.0);
        }
        if scale <= 0.0 {
            break;
        }
        let next: Vec<f64> = standardised.iter().map(|r| bisquare(r / scale)).collect();
        let change = next.iter().zip(&weights).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        weights = next;
        fit = solve(problem, fit.state, Some(&weights), options)?;
        if change < 1e-6 {
            break;
        }
    }
    Ok((fit, weights))
}

/// (1 − (z/c)²)² within c, 0 beyond.
fn bisquare(z: f64) -> f64 {
    let ratio = z / TUNING;
    if ratio.abs() >= 1.0 { 0.0 } else { (1.0 - ratio * ratio).powi(2) }
}
