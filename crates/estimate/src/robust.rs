//! Iteratively reweighted least squares with Tukey's bisquare.

use crate::gauss_newton::{Fit, Options, Problem, linearised, solve};
use crate::{Error, stats};

/// Tuning constant of the bisquare: 95 % efficiency for normal errors.
const TUNING: f64 = 4.685;
/// Most rounds of reweighting.
const ROUNDS: usize = 50;
/// Median of |z| for a standard normal z.
const MEDIAN_ABSOLUTE_NORMAL: f64 = 0.674_489_75;

/// A robust fit.
#[derive(Clone, Debug)]
pub struct RobustFit<S> {
    /// The minimum with the final weights.
    pub fit: Fit<S>,
    /// Weight of each reading, 0 to 1.
    pub weights: Vec<f64>,
    /// Standard deviation of a reading, in units of the declared one, that gives the covariance of the
    /// estimate when put on all readings alike: s √(Σψ²/(n − p)) / mean ψ' (Huber 1981, ch. 7).
    pub scale: f64,
}

/// Fits with readings far from the rest weighed down.
///
/// The scale s is the median absolute residual, corrected for leverage; with `known_scale` never below the
/// declared standard deviation.
pub fn solve_robust<P: Problem>(
    problem: &P,
    start: P::State,
    known_scale: bool,
) -> Result<RobustFit<P::State>, Error> {
    let readings = problem.readings();
    let mut weights = vec![1.0; readings];
    let options = Options::default();
    let mut fit = solve(problem, start, None, &options)?;
    let mut scale = 1.0;
    for _ in 0..ROUNDS {
        let standardised = standardised(problem, &fit, &weights);
        let mut absolute: Vec<f64> = standardised.iter().map(|r| r.abs()).collect();
        let median = scale_of(&mut absolute);
        let s = if known_scale { median.max(1.0) } else { median };
        if s <= 0.0 {
            break;
        }
        let z: Vec<f64> = standardised.iter().map(|r| r / s).collect();
        let next: Vec<f64> = z.iter().map(|z| bisquare(*z)).collect();
        let left = readings as f64 - fit.svd.leverage()[..readings].iter().sum::<f64>();
        let squares: f64 = z.iter().zip(&next).map(|(z, w)| (z * w).powi(2)).sum();
        let slope = z.iter().map(|z| slope(*z)).sum::<f64>() / readings as f64;
        scale = s * (squares / left.max(1.0)).sqrt() / slope.max(0.1);
        let change = next.iter().zip(&weights).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        weights = next;
        fit = solve(problem, fit.state, Some(&weights), &options)?;
        if change < 1e-6 {
            break;
        }
    }
    Ok(RobustFit { fit, weights, scale })
}

/// Standard deviation of normal numbers by the median of their sizes.
pub fn scale_of(sizes: &mut [f64]) -> f64 {
    stats::median_of(sizes) / MEDIAN_ABSOLUTE_NORMAL
}

/// Residuals without their weights, corrected for leverage.
fn standardised<P: Problem>(problem: &P, fit: &Fit<P::State>, weights: &[f64]) -> Vec<f64> {
    let (residual, _) = linearised(problem, &fit.state);
    let leverage = fit.svd.leverage();
    (0..weights.len())
        .map(|i| residual[i] / (1.0 - weights[i] * leverage[i].min(1.0)).max(1e-9).sqrt())
        .collect()
}

/// Derivative of ψ(z) = z (1 − (z/c)²)²: (1 − (z/c)²)(1 − 5 (z/c)²) within c, 0 beyond.
fn slope(z: f64) -> f64 {
    let square = (z / TUNING).powi(2);
    if square >= 1.0 { 0.0 } else { (1.0 - square) * (1.0 - 5.0 * square) }
}

/// (1 − (z/c)²)² within c, 0 beyond.
pub fn bisquare(z: f64) -> f64 {
    let ratio = z / TUNING;
    if ratio.abs() >= 1.0 { 0.0 } else { (1.0 - ratio * ratio).powi(2) }
}
