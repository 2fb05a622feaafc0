//! The maximum of the Whittle likelihood.

use super::likelihood::{EXPONENTS, Model};
use crate::Error;
use crate::scoring::{Optimum, minimise};

/// Exponents from which the search starts, and how many of these are followed to the end.
const STARTS: usize = 12;
const FOLLOWED: usize = 2;
/// Multiplicative steps of a start.
const START_STEPS: usize = 10;

impl Model<'_> {
    /// Least cost with flicker, from starts over all exponents and from those given.
    pub fn best(&self, given: &[Vec<f64>]) -> Result<Optimum, Error> {
        // With the exponent held the other unknowns get their least cost, so that no step from there loses
        // the flicker.
        let mut starts: Vec<Optimum> = (0..STARTS)
            .filter_map(|i| {
                let share = i as f64 / (STARTS - 1) as f64;
                let start = self.start(EXPONENTS.0 + (EXPONENTS.1 - EXPONENTS.0) * share);
                minimise(self, start, &[1]).ok()
            })
            .collect();
        starts.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let followed = starts.into_iter().take(FOLLOWED).map(|start| start.theta);
        let mut best: Result<Optimum, Error> =
            Err(Error::NotConverged { iterations: 0, last_shift: f64::NAN });
        for start in followed.chain(given.iter().cloned()) {
            let found = minimise(self, start, &[]);
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

    /// A start for one exponent: half the mean ordinate each for flicker and white noise, then multiplicative
    /// steps that each lower the cost.
    ///
    /// Source: C. Févotte and J. Idier, Algorithms for nonnegative matrix factorization with the
    /// β-divergence, Neural Computation 23 (2011) 2421–2456, β = 0.
    fn start(&self, exponent: f64) -> Vec<f64> {
        let mut theta = self.white_only();
        let (sum, count) = self.data.bins.iter().fold((0.0, 0.0), |(sum, count), bin| {
            (sum + bin.count * bin.density * (exponent * bin.x).exp(), count + bin.count)
        });
        (theta[0], theta[1]) = (0.5 * sum / count, exponent);
        theta[2..].iter_mut().for_each(|white| *white *= 0.5);
        for _ in 0..START_STEPS {
            let mut sums = vec![(0.0, 0.0); theta.len()];
            for (bin, flicker, white) in self.parts(&theta) {
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
}
