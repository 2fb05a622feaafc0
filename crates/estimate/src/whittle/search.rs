//! The maximum of the Whittle likelihood, and bounds by its ratio.

use faer::Mat;

use super::likelihood::{EXPONENTS, Model, Slope};
use crate::{Error, Svd};

/// Exponents from which the search starts, and how many of these are followed to the end.
const STARTS: usize = 12;
const FOLLOWED: usize = 2;
/// Multiplicative steps of a start.
const START_STEPS: usize = 10;
/// Most steps of the iteration, and most halvings of one.
const MOST_STEPS: usize = 200;
const MOST_HALVINGS: i32 = 30;
/// A step that gains less than this by the gradient is the last one (square of its length in standard deviations).
const LAST: f64 = 1e-10;
/// Where rounding stops the iteration, so small a gain is good enough.
const GOOD_ENOUGH: f64 = 1e-6;
/// Longest step in the exponent.
const LONGEST: f64 = 0.5;
/// Twice the fall in log likelihood at a one-sided 95 % bound: 1.645².
const BOUND: f64 = 2.705_543;
/// Relative accuracy of a bound.
const BOUND_ACCURACY: f64 = 1e-5;

/// A point with its cost.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub theta: Vec<f64>,
    pub cost: f64,
}

impl Model<'_> {
    /// Least cost over what is not held, from a start: steps by the second derivatives or by the Fisher information, within
    /// the limits and halved until they lead down.
    pub fn minimise(&self, mut theta: Vec<f64>, held: &[usize]) -> Result<Found, Error> {
        let free: Vec<usize> = (0..theta.len()).filter(|i| !held.contains(i)).collect();
        let mut expected = 0.0;
        for _ in 0..MOST_STEPS {
            let Slope { cost, gradient, hessian, fisher } = self.slope(&theta);
            let scoring = within(&theta, &fisher, &gradient, &free)?;
            expected = gain(&scoring, &gradient);
            if expected <= LAST {
                return Ok(Found { theta, cost });
            }
            let newton = within(&theta, &hessian, &gradient, &free)?;
            let down = |step: &Vec<f64>| {
                let moved = |halvings: i32| {
                    let share = 0.5_f64.powi(halvings);
                    let theta: Vec<f64> =
                        theta.iter().zip(step).map(|(theta, step)| theta + share * step).collect();
                    Found { cost: self.cost(&theta), theta }
                };
                (0..MOST_HALVINGS).map(moved).find(|moved| moved.cost < cost)
            };
            let steps = [newton, scoring];
            let next = steps.iter().filter(|step| gain(step, &gradient) > 0.0).filter_map(down);
            match next.min_by(|a, b| a.cost.total_cmp(&b.cost)) {
                Some(next) => theta = next.theta,
                None if expected < GOOD_ENOUGH => return Ok(Found { theta, cost }),
                None => break,
            }
        }
        Err(Error::NotConverged { iterations: MOST_STEPS, last_shift: expected.sqrt() })
    }

    /// Least cost with flicker, from starts over all exponents and from those given.
    pub fn best(&self, given: &[Vec<f64>]) -> Result<Found, Error> {
        // With the exponent held the other unknowns get their least cost, so that no step from there loses the flicker.
        let mut starts: Vec<Found> = (0..STARTS)
            .filter_map(|i| {
                let share = i as f64 / (STARTS - 1) as f64;
                let start = self.start(EXPONENTS.0 + (EXPONENTS.1 - EXPONENTS.0) * share);
                self.minimise(start, &[1]).ok()
            })
            .collect();
        starts.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let followed = starts.into_iter().take(FOLLOWED).map(|start| start.theta);
        let mut best: Result<Found, Error> = Err(Error::NotConverged { iterations: 0, last_shift: f64::NAN });
        for start in followed.chain(given.iter().cloned()) {
            let found = self.minimise(start, &[]);
            let better = match (&found, &best) {
                (Ok(found), Ok(best)) => found.cost < best.cost,
                (found, best) => found.is_ok() || best.is_err(),
            };
            if better {
                best = found;
            }
        }
        best
    }

    /// A start for one exponent: half the mean ordinate each for flicker and white noise, then multiplicative steps that
    /// each lower the cost.
    ///
    /// Source: C. Févotte and J. Idier, Algorithms for nonnegative matrix factorization with the β-divergence, Neural
    /// Computation 23 (2011) 2421–2456, β = 0.
    fn start(&self, exponent: f64) -> Vec<f64> {
        let mut theta = self.white_only();
        let (sum, count) = self.data.bins.iter().fold((0.0, 0.0), |(sum, count), bin| {
            (sum + bin.count * bin.density * (exponent * bin.x).exp(), count + bin.count)
        });
        (theta[0], theta[1]) = (0.5 * sum / count, exponent);
        theta[2..].iter_mut().for_each(|white| *white *= 0.5);
        for _ in 0..START_STEPS {
            let mut sums = vec![(0.0, 0.0); theta.len()];
            for bin in &self.data.bins {
                let (flicker, white) = self.parts(&theta, bin);
                let density = flicker + white;
                for (i, part) in [(0, flicker), (2 + self.group(bin.series), white)] {
                    sums[i].0 += bin.count * part * bin.density / (density * density);
                    sums[i].1 += bin.count * part / density;
                }
            }
            for (theta, (up, down)) in theta.iter_mut().zip(sums).filter(|(_, sums)| sums.0 > 0.0) {
                *theta *= (up / down).sqrt();
            }
        }
        theta
    }

    /// The one-sided 95 % bound of θ_i by the likelihood ratio, with `held` held: where the least cost over the others is
    /// 1.645²/2 above that at `best`.
    pub fn upper(&self, best: &Found, i: usize, held: &[usize]) -> Result<f64, Error> {
        let held: Vec<usize> = held.iter().copied().chain([i]).collect();
        let beyond = |at: f64| {
            let mut theta = best.theta.clone();
            theta[i] = at;
            Ok::<_, Error>(self.minimise(theta, &held)?.cost > best.cost + 0.5 * BOUND)
        };
        // Where the curvature puts it, then doubled until it is enclosed.
        let information = self.slope(&best.theta).fisher[(i, i)];
        let (mut low, mut high) = (best.theta[i], best.theta[i] + (BOUND / information).sqrt());
        while !beyond(high)? {
            (low, high) = (high, 2.0 * high);
        }
        while high - low > BOUND_ACCURACY * high {
            let middle = 0.5 * (low + high);
            if beyond(middle)? { high = middle } else { low = middle }
        }
        Ok(0.5 * (low + high))
    }
}

/// The step −M⁻¹ g among the unknowns `free` that keeps to the limits: what would pass its limit is moved just there,
/// and the others as is best with that.
fn within(theta: &[f64], matrix: &Mat<f64>, gradient: &[f64], free: &[usize]) -> Result<Vec<f64>, Error> {
    let limits = |i: usize| match i {
        1 => ((EXPONENTS.0 - theta[1]).max(-LONGEST), (EXPONENTS.1 - theta[1]).min(LONGEST)),
        _ => (-theta[i], f64::INFINITY),
    };
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

/// The inverse of the rows and columns `kept` of an information matrix, scaled to a diagonal of ones meanwhile; zero
/// elsewhere, and along directions of which there is no information.
pub(super) fn inverse(information: &Mat<f64>, kept: &[usize]) -> Result<Mat<f64>, Error> {
    const RANK_TOLERANCE: f64 = 1e-13;
    let mut inverse = Mat::zeros(information.nrows(), information.ncols());
    let kept: Vec<usize> = kept.iter().copied().filter(|&i| information[(i, i)] > 0.0).collect();
    if kept.is_empty() {
        return Ok(inverse);
    }
    let root: Vec<f64> = kept.iter().map(|&i| information[(i, i)].sqrt()).collect();
    let scaled =
        Mat::from_fn(kept.len(), kept.len(), |a, b| information[(kept[a], kept[b])] / root[a] / root[b]);
    let svd = Svd::of(scaled.as_ref(), RANK_TOLERANCE)?;
    for (b, &column) in kept.iter().enumerate() {
        let mut unit = vec![0.0; kept.len()];
        unit[b] = 1.0 / root[b];
        for (a, value) in svd.solve(&unit).into_iter().enumerate() {
            inverse[(kept[a], column)] = value / root[a];
        }
    }
    Ok(inverse)
}
