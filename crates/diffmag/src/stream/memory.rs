use faer::Mat;
use std::sync::LazyLock;

use crate::octave::Octave;

/// Levels between two differences, and places beside, that still covary.
const DEPTH: usize = 6;
const BESIDE: i64 = 2;

/// How a difference covaries with one of `depth` levels below, as a sum over the knots of [`curve`] from the
/// lower one's level on.
struct Kernel {
    depth: usize,
    knots: Vec<f64>,
}

impl Kernel {
    fn along(&self, curve: &[f64]) -> f64 {
        curve.iter().zip(&self.knots).map(|(g, weight)| g * weight).sum()
    }
}

/// All relations: to the neighbours on a level, and to the differences within and beside one's own blocks on
/// the levels below.
static KERNELS: LazyLock<Vec<Kernel>> = LazyLock::new(|| {
    let places = |depth: usize| (-BESIDE..(1 << depth) + BESIDE).map(move |place| (depth, place));
    let relations = (0..=DEPTH).flat_map(places).filter(|relation| *relation != (0, 0));
    relations.map(|(depth, place)| kernel(depth, place)).collect()
});

fn kernel(depth: usize, place: i64) -> Kernel {
    let mut knots = vec![0.0; depth + 6];
    let long = 1_i64 << depth;
    for (a, end) in [(1.0, 0), (-2.0, long), (1.0, 2 * long)] {
        for (b, other) in [(1.0, 2 * place), (-2.0, 2 * place + 1), (1.0, 2 * place + 2)] {
            let distance = (end - other).unsigned_abs();
            if distance > 0 {
                let weight = -a * b * (distance * distance) as f64 / long as f64;
                interpolate((distance as f64).log2(), weight, &mut knots);
            }
        }
    }
    Kernel { depth, knots }
}

/// Adds a value between knots: the cubic through the four around it.
fn interpolate(at: f64, weight: f64, knots: &mut [f64]) {
    let first = (at.floor() as usize).saturating_sub(1);
    let four = first..first + 4;
    for (i, knot) in knots.iter_mut().enumerate().take(four.end).skip(four.start) {
        let others = four.clone().filter(|j| *j != i);
        let share: f64 = others.map(|j| (at - j as f64) / (i as f64 - j as f64)).product();
        *knot += weight * share;
    }
}

/// g(2^L)/4^L, g the generalised covariance of a series' running sum, but for a constant. Because the
/// variance of the Haar differences is V = (8 g(m) − 2 g(2m))/m², it is −Σ V_l/8 over the levels l < L. With
/// it the covariance of any two differences is known from the variances by octave, the series being
/// stationary and its spectrum smooth.
fn curve(variances: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sum = 0.0;
    let mut knots = vec![0.0];
    let mut last = 0.0;
    for variance in variances {
        sum -= variance / 8.0;
        last = variance;
        knots.push(sum);
    }
    // Beyond the last level, as there.
    for _ in 0..DEPTH + 6 {
        sum -= last / 8.0;
        knots.push(sum);
    }
    knots
}

/// Pairs of differences of which both the noise and the reference covary: what is left out where differences
/// count as independent.
pub struct Memory {
    counts: Vec<f64>,
    noise: Vec<f64>,
    field: Vec<Vec<f64>>,
}

/// A relation between two levels.
pub struct Pair {
    pub lower: usize,
    /// The upper level, or the same.
    pub upper: usize,
    /// Ordered pairs of differences.
    pub count: f64,
    /// Covariance of their noise, nT².
    pub noise: f64,
    /// Mean product of the reference's x, y, z, nT².
    pub field: [[f64; 3]; 3],
}

impl Memory {
    /// Of octaves and the variances that noise with memory has there.
    pub fn of(octaves: &[Octave], flicker: &[f64]) -> Self {
        let element = |i: usize, j: usize| {
            curve(octaves.iter().filter(|octave| octave.count > 0.0).map(|o| o.products[i][j] / o.count))
        };
        Memory {
            counts: octaves.iter().map(|octave| octave.count).collect(),
            noise: curve(flicker.iter().copied()),
            field: (0..9).map(|at| element(at / 3, at % 3)).collect(),
        }
    }

    pub fn pairs(&self) -> impl Iterator<Item = Pair> {
        let levels = self.counts.len();
        (0..levels).flat_map(move |lower| {
            KERNELS.iter().filter(move |kernel| lower + kernel.depth < levels).map(move |kernel| {
                let upper = lower + kernel.depth;
                let at = |curve: &[f64]| kernel.along(&curve[lower.min(curve.len() - 1)..]);
                let field = std::array::from_fn(|i| std::array::from_fn(|j| at(&self.field[3 * i + j])));
                let both = if kernel.depth == 0 { 1.0 } else { 2.0 };
                Pair { lower, upper, count: both * self.counts[upper], noise: at(&self.noise), field }
            })
        })
    }

    /// Σ w_i w_j x_i x_jᵀ Cov(e_i, e_j) over all pairs, w by level.
    pub fn products(&self, weights: impl Fn(usize) -> f64) -> Mat<f64> {
        let mut sum = Mat::zeros(3, 3);
        for pair in self.pairs() {
            let factor = pair.count * weights(pair.lower) * weights(pair.upper) * pair.noise;
            for i in 0..3 {
                for j in 0..3 {
                    sum[(i, j)] += factor * 0.5 * (pair.field[i][j] + pair.field[j][i]);
                }
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use estimate::haar::{power_law_variances, sum_covariance};

    #[test]
    fn the_covariances_of_a_power_law_come_from_its_variances() {
        for exponent in [0.7, 1.0, 1.6] {
            let knots = curve(power_law_variances(exponent, 24).into_iter());
            let g = sum_covariance(exponent);
            let level = 10;
            let length = 2.0_f64.powi(level as i32);
            let variance = power_law_variances(exponent, level + 1)[level];
            for (depth, place) in [(0, 1), (1, 0), (1, 1), (2, 1), (3, 2), (4, 8)] {
                let long = 2.0_f64.powi(depth as i32);
                let start = 2.0 * place as f64;
                let mut exact = 0.0;
                for (a, end) in [(1.0, 0.0), (-2.0, long), (1.0, 2.0 * long)] {
                    for (b, other) in [(1.0, start), (-2.0, start + 1.0), (1.0, start + 2.0)] {
                        exact -= a * b * g(length * (end - other)) / (length * length * long);
                    }
                }
                let found = kernel(depth, place).along(&knots[level..]);
                assert!(
                    (found - exact).abs() < 0.02 * variance,
                    "{exponent} {depth} {place}: {found} {exact}"
                );
            }
        }
    }
}
