//! The maximum of the Whittle likelihood, and bounds by its ratio.

use faer::Mat;

use super::likelihood::{EXPONENTS, Model, Slope};
use crate::{Error, Svd};

/// Exponents from which the search starts.
const STARTS: usize = 12;
/// Multiplicative steps of a start.
const START_STEPS: usize = 30;
/// Most steps of the iteration, and most halvings of one.
const MOST_STEPS: usize = 300;
const MOST_HALVINGS: i32 = 30;
/// A step as short as this is the last one (square of its length in standard deviations).
const LAST: f64 = 1e-14;
/// Where rounding stops the iteration, a step as short as this is good enough.
const GOOD_ENOUGH: f64 = 1e-6;
/// Longest step in a logarithm or in the exponent.
const LONGEST: f64 = 3.0;
/// An unknown so near to its least value is there.
const AT_LEAST: f64 = 0.1;
/// Twice the fall in log likelihood at a one-sided 95 % bound: 1.645².
const BOUND: f64 = 2.705_543;
/// Accuracy of the logarithm of a bound.
const BOUND_ACCURACY: f64 = 1e-5;

/// A point with its cost.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub theta: Vec<f64>,
    pub cost: f64,
}

impl Model<'_> {
    /// Least cost over what is not held, from a start: Fisher scoring with halved steps within the limits.
    pub fn minimise(&self, mut theta: Vec<f64>, held: &[usize]) -> Result<Found, Error> {
        let largest = |i: usize| if i == 1 { EXPONENTS.1 } else { f64::INFINITY };
        let free: Vec<usize> = (0..theta.len()).filter(|i| !held.contains(i)).collect();
        free.iter().for_each(|&i| theta[i] = theta[i].clamp(self.least[i], largest(i)));
        let mut expected = 0.0_f64;
        for _ in 0..MOST_STEPS {
            let Slope { cost, gradient, fisher } = self.slope(&theta, false);
            let stuck = |i: usize| {
                (theta[i] <= self.least[i] && gradient[i] >= 0.0)
                    || (theta[i] >= largest(i) && gradient[i] <= 0.0)
            };
            let moving: Vec<usize> = free.iter().copied().filter(|i| !stuck(*i)).collect();
            let inverse = inverse(&fisher, &moving)?;
            let step = |i: usize| moving.iter().map(|&j| -inverse[(i, j)] * gradient[j]).sum::<f64>();
            let steps: Vec<(usize, f64)> = moving.iter().map(|&i| (i, step(i))).collect();
            expected = steps.iter().map(|(i, step)| -step * gradient[*i]).sum();
            if expected <= LAST {
                return Ok(Found { theta, cost });
            }
            let longest = steps.iter().map(|(_, step)| step.abs()).fold(LONGEST, f64::max);
            let next = |halvings: i32| {
                let share = LONGEST / longest * 0.5_f64.powi(halvings);
                let mut next = theta.clone();
                for &(i, step) in &steps {
                    next[i] = (next[i] + share * step).clamp(self.least[i], largest(i));
                }
                next
            };
            match (0..MOST_HALVINGS).map(next).find(|next| self.cost(next) < cost) {
                Some(next) => theta = next,
                None if expected < GOOD_ENOUGH => return Ok(Found { theta, cost }),
                None => break,
            }
        }
        Err(Error::NotConverged { iterations: MOST_STEPS, last_shift: expected.sqrt() })
    }

    /// Least cost with flicker, from the best of starts over all exponents and from those given. Parts that are
    /// negligible become none.
    pub fn best(&self, given: &[Vec<f64>]) -> Result<Found, Error> {
        let own = (0..STARTS).map(|i| {
            let share = i as f64 / (STARTS - 1) as f64;
            self.start(EXPONENTS.0 + (EXPONENTS.1 - EXPONENTS.0) * share)
        });
        let own = own.min_by(|a, b| self.cost(a).total_cmp(&self.cost(b)));
        let mut best: Result<Found, Error> = Err(Error::NotConverged { iterations: 0, last_shift: f64::NAN });
        for start in own.iter().chain(given) {
            let found = self.minimise(start.clone(), &[]);
            let better = match (&found, &best) {
                (Ok(found), Ok(best)) => found.cost < best.cost,
                (found, best) => found.is_ok() || best.is_err(),
            };
            if better {
                best = found;
            }
        }
        let mut best = best?;
        for i in (0..best.theta.len()).filter(|i| *i != 1) {
            if best.theta[i] <= self.least[i] + AT_LEAST {
                best.theta[i] = f64::NEG_INFINITY;
            }
        }
        Ok(best)
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
        (theta[0], theta[1]) = ((0.5 * sum / count).ln(), exponent);
        theta[2..].iter_mut().for_each(|white| *white -= std::f64::consts::LN_2);
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
                *theta += 0.5 * (up / down).ln();
            }
        }
        theta
    }

    /// The one-sided 95 % bound of exp θ_i by the likelihood ratio, with `held` held: where the least cost over the
    /// others is 1.645²/2 above that at `best`.
    pub fn upper(&self, best: &Found, i: usize, held: &[usize]) -> Result<f64, Error> {
        let held: Vec<usize> = held.iter().copied().chain([i]).collect();
        let excess = |at: f64| {
            let mut theta = best.theta.clone();
            theta[i] = at;
            Ok::<_, Error>(self.minimise(theta, &held)?.cost - best.cost - 0.5 * BOUND)
        };
        let mut theta = best.theta.clone();
        theta[i] = theta[i].max(self.least[i]);
        // Where the curvature puts it, then doubled or halved until it is enclosed.
        let information = self.slope(&theta, false).fisher[(i, i)];
        let mut high = theta[i] + (BOUND / information).sqrt().ln_1p();
        while excess(high)? < 0.0 {
            high += std::f64::consts::LN_2;
        }
        let mut low = high - std::f64::consts::LN_2;
        while low > theta[i] && excess(low)? > 0.0 {
            (high, low) = (low, low - std::f64::consts::LN_2);
        }
        low = low.max(theta[i]);
        while high - low > BOUND_ACCURACY {
            let middle = 0.5 * (low + high);
            if excess(middle)? < 0.0 { low = middle } else { high = middle }
        }
        Ok((0.5 * (low + high)).exp())
    }
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
