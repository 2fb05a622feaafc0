//! Gauss-Newton iteration with an SVD inverse and step halving.

use faer::{Mat, MatMut};

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

    /// Residuals (observed − predicted)/σ and the derivative of predicted/σ along each step component.
    /// Both arrive filled with zeros.
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
    /// Most steps.
    pub max_iterations: usize,
    /// A step that moves the predictions by less than this many standard deviations (root of the sum
    /// of squares over all rows) is the last one.
    pub tolerance: f64,
    /// Singular values below this share of the largest count as zero.
    pub rank_tolerance: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { max_iterations: 60, tolerance: 1e-7, rank_tolerance: 1e-9 }
    }
}

/// One step of the iteration.
#[derive(Clone, Debug)]
pub struct Step {
    /// Sum of squares before the step.
    pub cost: f64,
    /// The step taken.
    pub step: Vec<f64>,
    /// Rank of the linearised problem.
    pub rank: usize,
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
const ROUNDING: f64 = 1e-7;
/// Halvings of a step before it is given up.
const HALVINGS: usize = 30;

/// Minimises the sum of squares from `start`. Where the problem is short of rank, each step is the
/// minimum-norm one and the fit says so in its rank; it is for the caller to refuse.
///
/// `weights`, one for each reading in 0..=1, multiply the squared residuals.
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
    let linearise = |state: &P::State| {
        let (mut residual, mut jacobian) = linearised(problem, state);
        for (i, weight) in weights.unwrap_or_default().iter().enumerate() {
            let root = weight.sqrt();
            residual[i] *= root;
            (0..unknowns).for_each(|j| jacobian[(i, j)] *= root);
        }
        let cost = residual.iter().map(|r| r * r).sum::<f64>();
        (residual, jacobian, cost)
    };

    let mut state = start;
    let (mut residual, mut jacobian, mut cost) = linearise(&state);
    let mut steps = Vec::new();
    let mut last_shift = f64::INFINITY;
    while steps.len() < options.max_iterations {
        let svd = Svd::of(jacobian.as_ref(), options.rank_tolerance)?;
        let mut step = svd.solve(&residual);
        let shift = shift(&jacobian, &step);
        // Steps that are small and no longer shrink are rounding.
        let stalled = shift > 0.5 * last_shift && shift * shift <= ROUNDING * (1.0 + cost);
        if shift <= options.tolerance || stalled {
            return Ok(Fit { state, residual, jacobian, svd, cost, steps });
        }
        last_shift = shift;
        let mut trial = None;
        for _ in 0..HALVINGS {
            let next = problem.advance(&state, &step);
            let linearised = linearise(&next);
            if linearised.2 <= cost + ROUNDING * (1.0 + cost) {
                trial = Some((next, linearised));
                break;
            }
            step.iter_mut().for_each(|s| *s *= 0.5);
        }
        let Some((next, linearised)) = trial else { break };
        steps.push(Step { cost, step, rank: svd.rank() });
        state = next;
        (residual, jacobian, cost) = linearised;
    }
    Err(Error::NotConverged { iterations: steps.len(), last_shift })
}

/// ‖J δ‖: how far a step moves the predictions, in standard deviations.
fn shift(jacobian: &Mat<f64>, step: &[f64]) -> f64 {
    let mut moved = vec![0.0; jacobian.nrows()];
    for (j, s) in step.iter().enumerate() {
        for (m, a) in moved.iter_mut().zip(jacobian.col_as_slice(j)) {
            *m += a * s;
        }
    }
    moved.iter().map(|m| m * m).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NIST StRD Misra1a: y = b1 (1 − e^(−b2 x)), lower difficulty; certified to 11 digits.
    struct Misra1a;

    const X: [f64; 14] =
        [77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0];
    const Y: [f64; 14] =
        [10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78];

    impl Problem for Misra1a {
        type State = [f64; 2];
        fn unknowns(&self) -> usize {
            2
        }
        fn rows(&self) -> usize {
            X.len()
        }
        fn linearise(&self, b: &[f64; 2], residual: &mut [f64], mut jacobian: MatMut<'_, f64>) {
            for i in 0..X.len() {
                let decay = (-b[1] * X[i]).exp();
                residual[i] = Y[i] - b[0] * (1.0 - decay);
                jacobian[(i, 0)] = 1.0 - decay;
                jacobian[(i, 1)] = b[0] * X[i] * decay;
            }
        }
        fn advance(&self, b: &[f64; 2], step: &[f64]) -> [f64; 2] {
            [b[0] + step[0], b[1] + step[1]]
        }
    }

    #[test]
    fn nist_misra1a_from_both_starts() {
        for start in [[500.0, 1e-4], [250.0, 5e-4]] {
            let options = Options { tolerance: 1e-9, ..Options::default() };
            let fit = solve(&Misra1a, start, None, &options).expect("a minimum");
            assert!((fit.state[0] / 2.389_421_291_8e2 - 1.0).abs() < 1e-9, "{:?}", fit.state);
            assert!((fit.state[1] / 5.501_564_318_1e-4 - 1.0).abs() < 1e-9);
            assert!((fit.cost / 1.245_513_889_4e-1 - 1.0).abs() < 1e-9);
            let variance = fit.cost / fit.degrees_of_freedom();
            let std = (variance * fit.svd.covariance()[(0, 0)]).sqrt();
            assert!((std / 2.707_007_524_1 - 1.0).abs() < 1e-8, "{std}");
        }
    }
}
