//! The iteration, whatever it goes down in and however its steps are made.

/// What an iteration goes down in. A point is a state of the unknowns with what it leaves of the readings.
pub trait Descent {
    /// A state with its residual.
    type Point;
    /// The linear problem about a point.
    type Linear: Linear;
    /// Why a prediction cannot be made.
    type Error;

    /// The sum of squares at a point.
    fn cost(&self, at: &Self::Point) -> f64;

    /// The linear problem about a point; costly derivatives of a `kept` one nearby may be used again.
    fn linear(&self, at: &Self::Point, kept: Option<&Self::Linear>) -> Result<Self::Linear, Self::Error>;

    /// The point that a step leads to.
    fn moved(&self, at: &Self::Point, step: &[f64]) -> Result<Self::Point, Self::Error>;
}

/// A linear least-squares problem.
pub trait Linear {
    /// The step of least squares, whole without damping, and the shorter the more.
    fn step(&self, damping: f64) -> Vec<f64>;

    /// How far that step moves the predictions, in the unit of [`Control::tolerance`].
    fn shift(&self, damping: f64) -> f64;

    /// How many directions of the unknowns show.
    fn rank(&self) -> usize;
}

/// How steps are damped.
#[derive(Clone, Copy, Debug)]
pub struct Damping {
    /// Of the first step.
    pub first: f64,
    /// The least.
    pub least: f64,
    /// The least that is tried after a step of damping zero.
    pub from: f64,
}

impl Damping {
    fn heavier(&self, damping: f64) -> f64 {
        (damping * HEAVIER).max(self.from)
    }

    fn lighter(&self, damping: f64) -> f64 {
        let lighter = damping / HEAVIER;
        if lighter < self.from { self.least } else { lighter }
    }
}

/// Of a sum of squares.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// In its unit.
    pub absolute: f64,
    /// As a share of it.
    pub relative: f64,
}

impl Tolerance {
    fn of(&self, cost: f64) -> f64 {
        self.absolute + self.relative * cost
    }
}

/// How an iteration goes and when it ends.
#[derive(Clone, Copy, Debug)]
pub struct Control {
    /// Most steps.
    pub most: usize,
    /// A point from which the step moves the predictions by no more is a minimum.
    pub tolerance: f64,
    /// How steps are damped.
    pub damping: Damping,
    /// A step may raise the cost by this: what is rounding in it.
    pub raise: Tolerance,
    /// Also a minimum: a point reached by two steps that each lowered the cost by less, when the next step is
    /// more than half as long: rounding, or an unknown at its bound. None where the cost does not tell that.
    pub idle: Option<Tolerance>,
    /// Whether derivatives are expensive. Then linear problems are kept as long as steps need no more than
    /// the least damping, a minimum is confirmed by a new one, and the step from there is taken as well if it
    /// leads down, without yet another.
    pub keep: bool,
    /// The iteration ends where four times what the next step promises does not lead below this cost.
    pub reach: Option<f64>,
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

/// Where an iteration ended.
#[derive(Clone, Debug)]
pub struct Minimum<P, L> {
    /// The point.
    pub at: P,
    /// The linear problem about it, or about where the step at the end began.
    pub linear: L,
    /// How far the step that would come next would move the predictions.
    pub shift: f64,
    /// The steps that led here.
    pub steps: Vec<Step>,
    /// Whether it is a minimum: not if the steps ran out, or if none led down.
    pub settled: bool,
}

const HEAVIER: f64 = 10.0;
/// Where a step of this damping does not lead down, none does.
const HEAVIEST: f64 = 1e3;
/// A step of this damping is a small part of the whole one.
const MUCH: f64 = 1.0;
/// If no step, or only a heavily damped one, lowers the cost, the point has converged when the undamped step
/// is below this many tolerances: residuals of readings without noise are rounding.
const ROUNDED: f64 = 1e4;
/// A step may lead further down than the linear problem promises, so many times.
const FURTHER: f64 = 4.0;
/// So many steps that lower the cost by next to nothing are enough.
const IDLE: usize = 2;
/// A step longer than this share of the one before does not shrink.
const SHRINKS: f64 = 0.5;

/// Goes down from a point by steps of least squares, the first of them from a linear problem about it, or
/// from one to `begin` with that holds derivatives of another point.
///
/// A step is damped tenfold until it leads down, and the next one by a tenth (K. Levenberg, Q. Appl. Math. 2
/// (1944) 164; D. W. Marquardt, J. SIAM 11 (1963) 431); see [`super::Directions`].
///
/// Errors: those of the problem.
pub fn minimise<D: Descent>(
    descent: &D,
    mut at: D::Point,
    begin: Option<D::Linear>,
    control: &Control,
) -> Result<Minimum<D::Point, D::Linear>, D::Error> {
    let mut is_new = begin.is_none();
    let mut linear = match begin {
        Some(begin) => begin,
        None => descent.linear(&at, None)?,
    };
    let mut damping = control.damping.first;
    let mut steps = Vec::new();
    let mut last = Last { shift: f64::INFINITY, idle: 0, damping: 0.0, was_new: false };
    loop {
        let cost = descent.cost(&at);
        let shift = linear.shift(damping);
        let out_of_reach = |reach: f64| !steps.is_empty() && cost - FURTHER * shift * shift > reach;
        if control.reach.is_some_and(out_of_reach) {
            return Ok(Minimum { at, linear, shift, steps, settled: false });
        }
        let near = shift <= control.tolerance;
        let idle = last.idle >= IDLE && shift > SHRINKS * last.shift;
        if (near && is_new) || (idle && last.was_new) || steps.len() == control.most {
            // Where steps are damped that much, all of them are short.
            let rounded = || last.damping < MUCH || linear.shift(0.0) <= ROUNDED * control.tolerance;
            let settled = (near && is_new) || (idle && last.was_new && rounded());
            if control.keep {
                let end = descent.moved(&at, &linear.step(damping))?;
                at = if descent.cost(&end) <= cost { end } else { at };
            }
            return Ok(Minimum { at, linear, shift, steps, settled });
        }
        let confirm = (near || idle) && !is_new;
        let next = if confirm { None } else { down(descent, &at, &linear, &mut damping, control)? };
        match next {
            Some((next, step)) => {
                steps.push(Step { cost, step, rank: linear.rank() });
                let lowered = cost - descent.cost(&next);
                let is_idle = control.idle.is_some_and(|idle| lowered < idle.of(cost));
                last =
                    Last { shift, idle: if is_idle { last.idle + 1 } else { 0 }, damping, was_new: is_new };
                at = next;
                is_new = !control.keep || damping > control.damping.least;
                linear = descent.linear(&at, Some(&linear).filter(|_| !is_new))?;
                damping = control.damping.lighter(damping);
            }
            None if is_new => {
                let settled = linear.shift(0.0) <= ROUNDED * control.tolerance;
                return Ok(Minimum { at, linear, shift, steps, settled });
            }
            None => {
                (linear, is_new) = (descent.linear(&at, None)?, true);
                damping = damping.min(control.damping.first.max(control.damping.from));
            }
        }
    }
}

struct Last {
    shift: f64,
    /// How many steps up to it lowered the cost by next to nothing.
    idle: usize,
    damping: f64,
    /// Whether its linear problem was new.
    was_new: bool,
}

/// A point that a step led down to, and the step.
type Lower<D> = (<D as Descent>::Point, Vec<f64>);

/// Where a step leads down to, damped as much as that needs; None where it does not.
fn down<D: Descent>(
    descent: &D,
    at: &D::Point,
    linear: &D::Linear,
    damping: &mut f64,
    control: &Control,
) -> Result<Option<Lower<D>>, D::Error> {
    let cost = descent.cost(at);
    let most = cost + control.raise.of(cost);
    while *damping <= HEAVIEST {
        let step = linear.step(*damping);
        let next = descent.moved(at, &step)?;
        let reached = descent.cost(&next);
        if reached.is_finite() && reached <= most {
            return Ok(Some((next, step)));
        }
        *damping = control.damping.heavier(*damping);
    }
    Ok(None)
}
