//! The maximum of a likelihood by scoring, within limits, and bounds by its ratio.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use crate::line_search::{self, Accuracy, halved};
use crate::{Error, Svd};

/// Most steps of the iteration, and most halvings of one.
const MOST_STEPS: usize = 200;
const MOST_HALVINGS: i32 = 30;
/// A step that gains less than this by the gradient (standard deviations squared) is the last one.
const LAST: f64 = 1e-10;
/// Where the iteration gets no farther, so small a gain is good enough: a hundredth of a standard deviation.
const GOOD_ENOUGH: f64 = 1e-4;
/// The same beside a bound, which is where twice the cost is 2.7 higher. Without an amplitude its exponent is
/// of no consequence, and the way to an amplitude of zero is a long curved valley.
const BOUND_ENOUGH: f64 = 1e-2;
/// Twice the fall in log likelihood at a one-sided 95 % bound: 1.645².
const BOUND: f64 = 2.705_543;
/// Relative accuracy of a bound.
const BOUND_ACCURACY: f64 = 1e-5;

/// Minus a log likelihood over unknowns θ, up to a constant.
pub(crate) trait Likelihood {
    /// Its value.
    fn cost(&self, theta: &[f64]) -> f64;
    /// With its derivatives.
    fn slope(&self, theta: &[f64]) -> Slope;
    /// The least and the greatest step of one unknown.
    fn limits(&self, theta: &[f64], unknown: usize) -> (f64, f64);
}

/// Cost, its gradient, its second derivatives and their expectation (the Fisher information), over θ.
pub(crate) struct Slope {
    pub cost: f64,
    pub gradient: Vec<f64>,
    pub hessian: Mat<f64>,
    pub fisher: Mat<f64>,
}

/// A point with its cost.
#[derive(Clone, Debug)]
pub(crate) struct Optimum {
    pub theta: Vec<f64>,
    pub cost: f64,
}

/// Least cost over what is not held, from a start: steps by the second derivatives or by the Fisher
/// information, within the limits and halved until they lead down.
pub(crate) fn minimise(
    likelihood: &impl Likelihood,
    theta: Vec<f64>,
    held: &[usize],
) -> Result<Optimum, Error> {
    minimise_to(likelihood, theta, held, GOOD_ENOUGH)
}

fn minimise_to(
    likelihood: &impl Likelihood,
    mut theta: Vec<f64>,
    held: &[usize],
    good_enough: f64,
) -> Result<Optimum, Error> {
    let free: Vec<usize> = (0..theta.len()).filter(|i| !held.contains(i)).collect();
    let mut expected = 0.0;
    for _ in 0..MOST_STEPS {
        let Slope { cost, gradient, hessian, fisher } = likelihood.slope(&theta);
        let scoring = within(likelihood, &theta, &fisher, &gradient, &free)?;
        expected = gain(&scoring, &gradient);
        if expected <= LAST {
            return Ok(Optimum { theta, cost });
        }
        let newton = within(likelihood, &theta, &hessian, &gradient, &free)?;
        let down = |step: &Vec<f64>| {
            halved(MOST_HALVINGS, |share| {
                let theta: Vec<f64> =
                    theta.iter().zip(step).map(|(theta, step)| theta + share * step).collect();
                let moved = likelihood.cost(&theta);
                (moved < cost).then_some(Optimum { cost: moved, theta })
            })
        };
        // Newton's step; where it does not lead down, that of the Fisher information, which always does.
        match [newton, scoring].iter().filter(|step| gain(step, &gradient) > 0.0).find_map(down) {
            Some(next) => theta = next.theta,
            None => break,
        }
    }
    if expected < good_enough {
        return Ok(Optimum { cost: likelihood.cost(&theta), theta });
    }
    Err(Error::NotConverged { iterations: MOST_STEPS, last_shift: expected.sqrt() })
}

/// Twice the fall in log likelihood where θ_i is zero, with `held` held too.
pub(crate) fn fall_without(
    likelihood: &impl Likelihood,
    best: &Optimum,
    i: usize,
    held: &[usize],
) -> Result<f64, Error> {
    let mut without = best.theta.clone();
    without[i] = 0.0;
    let held: Vec<usize> = held.iter().copied().chain([i]).collect();
    Ok(2.0 * (minimise(likelihood, without, &held)?.cost - best.cost))
}

/// The one-sided 95 % bound of θ_i, `held` held: where the least cost is 1.645²/2 above `best`.
pub(crate) fn upper(
    likelihood: &impl Likelihood,
    best: &Optimum,
    i: usize,
    held: &[usize],
) -> Result<f64, Error> {
    let held: Vec<usize> = held.iter().copied().chain([i]).collect();
    // Standard deviations beyond the bound: nearly a straight line.
    let beyond = |at: f64| {
        let mut theta = best.theta.clone();
        theta[i] = at;
        let fall = minimise_to(likelihood, theta, &held, BOUND_ENOUGH)?.cost - best.cost;
        Ok::<_, Error>((2.0 * fall.max(0.0)).sqrt() - BOUND.sqrt())
    };
    // Where the curvature puts it, then doubled until it is enclosed.
    let information = likelihood.slope(&best.theta).fisher[(i, i)];
    let (mut low, mut high) = (best.theta[i], best.theta[i] + (BOUND / information).sqrt());
    let (mut below, mut above) = (-BOUND.sqrt(), beyond(high)?);
    while above < 0.0 {
        (low, below, high) = (high, above, 2.0 * high);
        above = beyond(high)?;
    }
    let accuracy = Accuracy { relative: BOUND_ACCURACY, value: BOUND_ACCURACY };
    line_search::zero((low, below), (high, above), accuracy, beyond)
}

/// The step −M⁻¹ g among `free` within the limits; what would pass its limit moves just there.
fn within(
    likelihood: &impl Likelihood,
    theta: &[f64],
    matrix: &Mat<f64>,
    gradient: &[f64],
    free: &[usize],
) -> Result<Vec<f64>, Error> {
    let limits = |i: usize| likelihood.limits(theta, i);
    let stuck = |i: usize| {
        let (low, high) = limits(i);
        (low >= 0.0 && gradient[i] >= 0.0) || (high <= 0.0 && gradient[i] <= 0.0)
    };
    let mut step = vec![0.0; theta.len()];
    let mut moving: Vec<usize> = free.iter().copied().filter(|i| !stuck(*i)).collect();
    loop {
        let inverse = inverse(matrix, &moving)?;
        let others: Vec<usize> = (0..theta.len()).filter(|i| !moving.contains(i)).collect();
        let right = |i: usize| gradient[i] + others.iter().map(|&j| matrix[(i, j)] * step[j]).sum::<f64>();
        let right: Vec<f64> = moving.iter().map(|&i| right(i)).collect();
        for &i in &moving {
            step[i] = -moving.iter().zip(&right).map(|(&j, right)| inverse[(i, j)] * right).sum::<f64>();
        }
        let before = moving.len();
        moving.retain(|&i| (limits(i).0..=limits(i).1).contains(&step[i]));
        for &i in free.iter().filter(|i| !moving.contains(i)) {
            step[i] = step[i].clamp(limits(i).0, limits(i).1);
        }
        if moving.len() == before {
            return Ok(step);
        }
    }
}

/// What a step gains by the gradient.
fn gain(step: &[f64], gradient: &[f64]) -> f64 {
    -step.iter().zip(gradient).map(|(step, gradient)| step * gradient).sum::<f64>()
}

/// The inverse of the rows and columns `kept`, scaled to a diagonal of ones meanwhile; zero elsewhere, and
/// along directions without information. Second derivatives need not be positive definite.
pub(crate) fn inverse(information: &Mat<f64>, kept: &[usize]) -> Result<Mat<f64>, Error> {
    const RANK_TOLERANCE: f64 = 1e-13;
    let mut inverse = Mat::zeros(information.nrows(), information.ncols());
    let kept: Vec<usize> = kept.iter().copied().filter(|&i| information[(i, i)] > 0.0).collect();
    if kept.is_empty() {
        return Ok(inverse);
    }
    let root: Vec<f64> = kept.iter().map(|&i| information[(i, i)].sqrt()).collect();
    let scaled =
        Mat::from_fn(kept.len(), kept.len(), |a, b| information[(kept[a], kept[b])] / root[a] / root[b]);
    let unit = Mat::from_fn(kept.len(), kept.len(), |a, b| if a == b { 1.0 / root[b] } else { 0.0 });
    let solved = match scaled.llt(Side::Lower) {
        Ok(factor) if (0..kept.len()).all(|a| factor.L()[(a, a)].powi(2) > RANK_TOLERANCE) => {
            factor.solve(&unit)
        }
        _ => {
            let svd = Svd::of(scaled.as_ref(), RANK_TOLERANCE)?;
            let mut solved = Mat::zeros(kept.len(), kept.len());
            for b in 0..kept.len() {
                solved.col_as_slice_mut(b).copy_from_slice(&svd.solve(unit.col_as_slice(b)));
            }
            solved
        }
    };
    for (b, &column) in kept.iter().enumerate() {
        for (a, &row) in kept.iter().enumerate() {
            inverse[(row, column)] = solved[(a, b)] / root[a];
        }
    }
    Ok(inverse)
}
