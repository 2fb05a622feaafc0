//! Problems that hand in dense rows.

use faer::{Mat, MatMut};

use super::descent::{Control, Damping, Descent, Minimum, Step, Tolerance, minimise};
use super::directions::Directions;
use crate::{Error, Svd};

/// A nonlinear least-squares problem whose state may live on a curved space (a unit sphere, say):
/// steps are small vectors, and the problem itself says how a state moves along one.
pub trait Problem {
    /// The unknowns.
    type State: Clone;

    /// Length of a step.
    fn unknowns(&self) -> usize;

    /// Number of rows: readings first, then rows of prior knowledge.
    fn rows(&self) -> usize;

    /// How many of the rows are readings. Priors are never weighed down and never doubtful.
    fn readings(&self) -> usize {
        self.rows()
    }

    /// (observed − predicted)/σ and the derivatives of predicted/σ along the step; both arrive as zeros.
    fn linearise(&self, state: &Self::State, residual: &mut [f64], jacobian: MatMut<'_, f64>);

    /// The state moved by a step.
    fn advance(&self, state: &Self::State, step: &[f64]) -> Self::State;
}

/// Residual and Jacobian of a problem at a state.
pub fn linearised<P: Problem>(problem: &P, state: &P::State) -> (Vec<f64>, Mat<f64>) {
    let mut residual = vec![0.0; problem.rows()];
    let mut jacobian = Mat::zeros(problem.rows(), problem.unknowns());
    problem.linearise(state, &mut residual, jacobian.as_mut());
    (residual, jacobian)
}

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// A point from which the step moves the predictions by less than this many standard deviations (root of
    /// the sum of squares over all rows) is the minimum.
    pub tolerance: f64,
    /// Singular values below this share of the largest count as zero.
    pub rank_tolerance: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { tolerance: 1e-7, rank_tolerance: 1e-9 }
    }
}

/// The minimum and the linearised problem there.
#[derive(Clone, Debug)]
pub struct Fit<S> {
    /// The unknowns.
    pub state: S,
    /// Weighted residuals at the minimum.
    pub residual: Vec<f64>,
    /// Weighted Jacobian of the prediction at the minimum.
    pub jacobian: Mat<f64>,
    /// Its decomposition.
    pub svd: Svd,
    /// Sum of squared residuals.
    pub cost: f64,
    /// The steps that led here.
    pub steps: Vec<Step>,
}

impl<S> Fit<S> {
    /// Rows less rank.
    pub fn degrees_of_freedom(&self) -> f64 {
        self.residual.len() as f64 - self.svd.rank() as f64
    }
}

/// Relative rounding of a sum of squares: residuals are differences of readings many times their size.
const ROUNDING: Tolerance = Tolerance { absolute: 1e-7, relative: 1e-7 };
/// The damping that follows on none: small beside the squares of the weakest directions that priors of a per cent leave beside
/// readings of a millionth, along which a curved valley leads down.
const FROM: f64 = 1e-10;
const MOST: usize = 60;

/// Minimises the sum of squares from `start`. Where the problem is short of rank, each step is the
/// minimum-norm one and the fit says so in its rank; it is for the caller to refuse.
///
/// `weights`, one for each reading in 0..=1, multiply the squared residuals.
///
/// Errors: [`Error::NotConverged`] where no minimum is reached, [`Error::TooFew`] without rows or
/// unknowns.
pub fn solve<P: Problem>(
    problem: &P,
    start: P::State,
    weights: Option<&[f64]>,
    options: &Options,
) -> Result<Fit<P::State>, Error> {
    let (rows, unknowns) = (problem.rows(), problem.unknowns());
    if rows == 0 || unknowns == 0 {
        return Err(Error::TooFew { found: rows, unknowns });
    }
    let dense = Dense { problem, weights, rank_tolerance: options.rank_tolerance };
    let control = Control {
        most: MOST,
        tolerance: options.tolerance,
        damping: Damping { first: 0.0, least: 0.0, from: FROM },
        raise: ROUNDING,
        idle: Some(ROUNDING),
        keep: false,
        reach: None,
    };
    let Minimum { at, linear, steps, settled, shift } = minimise(&dense, dense.at(start), None, &control)?;
    if !settled {
        return Err(Error::NotConverged { iterations: steps.len(), last_shift: shift });
    }
    let At { state, residual, jacobian, cost } = at;
    Ok(Fit { state, residual, jacobian, svd: linear.of, cost, steps })
}

struct Dense<'a, P> {
    problem: &'a P,
    weights: Option<&'a [f64]>,
    rank_tolerance: f64,
}

struct At<S> {
    state: S,
    residual: Vec<f64>,
    jacobian: Mat<f64>,
    cost: f64,
}

impl<P: Problem> Dense<'_, P> {
    fn at(&self, state: P::State) -> At<P::State> {
        let (mut residual, mut jacobian) = linearised(self.problem, &state);
        for (i, weight) in self.weights.unwrap_or_default().iter().enumerate() {
            let root = weight.sqrt();
            residual[i] *= root;
            (0..jacobian.ncols()).for_each(|j| jacobian[(i, j)] *= root);
        }
        let cost = residual.iter().map(|r| r * r).sum();
        At { state, residual, jacobian, cost }
    }
}

impl<P: Problem> Descent for Dense<'_, P> {
    type Point = At<P::State>;
    type Linear = Directions<Svd>;
    type Error = Error;

    fn cost(&self, at: &Self::Point) -> f64 {
        at.cost
    }

    fn linear(&self, at: &Self::Point, _: Option<&Self::Linear>) -> Result<Self::Linear, Error> {
        Ok(Directions::of_svd(Svd::of(at.jacobian.as_ref(), self.rank_tolerance)?, &at.residual))
    }

    fn moved(&self, at: &Self::Point, step: &[f64]) -> Result<Self::Point, Error> {
        Ok(self.at(self.problem.advance(&at.state, step)))
    }
}
