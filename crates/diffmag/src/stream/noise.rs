//! Restricted likelihood of one axis' noise and coefficients over octaves and slow blocks.

use estimate::haar::power_law_variances;
use estimate::positive::Positive;
use faer::Mat;

use super::memory::Memory;
use super::octaves::length;
use super::slow::Slow;
use crate::Error;
use crate::octave::{Octave, UNKNOWNS};

/// For derivatives by the exponent.
pub const SMALL: f64 = 1e-4;

/// White noise and a power law: the density a Δt (f Δt)^-α + 2 w Δt.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    /// a, nT².
    pub amplitude: f64,
    /// α.
    pub exponent: f64,
    /// w, nT².
    pub white: f64,
}

impl Noise {
    /// Variances of the Haar differences at so many levels, nT².
    pub fn variances(&self, levels: usize) -> Vec<f64> {
        let flicker = power_law_variances(self.exponent, levels);
        let white = |level: usize| 2.0 * self.white / 2.0_f64.powi(level as i32);
        flicker.iter().enumerate().map(|(level, v)| self.amplitude * v + white(level)).collect()
    }

    /// Of (ln a, α, ln w).
    pub fn of(theta: [f64; 3]) -> Self {
        Noise { amplitude: theta[0].exp(), exponent: theta[1], white: theta[2].exp() }
    }
}

/// What is known of an axis.
pub struct Problem<'a> {
    /// Octaves within a stretch.
    pub octaves: &'a [Octave],
    pub slow: &'a Slow,
    /// Their steps in the columns of the octaves.
    pub steps: Mat<f64>,
}

/// Coefficients under a given noise.
pub struct Solution {
    /// Corrections of η₀ (nT/nT) and drift (nT a place).
    pub coefficients: Vec<f64>,
    pub covariance: Mat<f64>,
    /// Variances of the octaves' differences.
    pub variances: Vec<f64>,
    /// −2 ln of the restricted likelihood.
    pub cost: f64,
    /// Σ of the squares, each over its variance.
    squares: f64,
    steps_inverse: Mat<f64>,
}

/// What the likelihood does about a noise.
pub(super) struct Slope {
    /// Derivatives of the cost to (ln a, α, ln w).
    pub gradient: [f64; 3],
    /// Their Fisher information, the differences independent.
    pub information: Mat<f64>,
    /// For each of them and each octave ∂ ln V.
    pub relative: [Vec<f64>; 3],
}

impl Problem<'_> {
    /// Variances of the octaves and covariance of the steps.
    fn model(&self, noise: &Noise) -> (Vec<f64>, Mat<f64>) {
        let (mut octaves, mut steps) = self.white();
        octaves.iter_mut().for_each(|variance| *variance *= noise.white);
        steps *= faer::Scale(noise.white);
        if noise.amplitude > 0.0 {
            let (flicker, slow) = self.power_law(noise.exponent);
            octaves.iter_mut().zip(flicker).for_each(|(all, flicker)| *all += noise.amplitude * flicker);
            steps += slow * faer::Scale(noise.amplitude);
        }
        (octaves, steps)
    }

    fn white(&self) -> (Vec<f64>, Mat<f64>) {
        ((0..self.octaves.len()).map(|level| 2.0 / length(level)).collect(), self.slow.white())
    }

    fn power_law(&self, exponent: f64) -> (Vec<f64>, Mat<f64>) {
        (power_law_variances(exponent, self.octaves.len()), self.slow.power_law(exponent))
    }

    /// Corrections of η₀ and the drift by generalised least squares.
    pub fn solve(&self, noise: &Noise) -> Result<Solution, Error> {
        let (variances, steps) = self.model(noise);
        let steps = Positive::of(&steps)?;
        let weighted = self.steps.transpose() * &steps.inverse * &self.steps;
        let octaves = || self.octaves.iter().zip(&variances);
        let normal = Mat::from_fn(UNKNOWNS + 1, UNKNOWNS + 1, |i, j| {
            weighted[(i, j)] + octaves().map(|(octave, v)| octave.products[i][j] / v).sum::<f64>()
        });
        let left = Positive::of(&Mat::from_fn(UNKNOWNS, UNKNOWNS, |i, j| normal[(i, j)]))?;
        let coefficients: Vec<f64> = (0..UNKNOWNS)
            .map(|i| (0..UNKNOWNS).map(|j| left.inverse[(i, j)] * normal[(j, UNKNOWNS)]).sum())
            .collect();
        let explained: f64 = (0..UNKNOWNS).map(|i| coefficients[i] * normal[(i, UNKNOWNS)]).sum();
        let squares = normal[(UNKNOWNS, UNKNOWNS)] - explained;
        let octaves: f64 = octaves().map(|(octave, v)| octave.count * v.ln()).sum();
        Ok(Solution {
            cost: octaves + steps.log_determinant + left.log_determinant + squares,
            squares,
            coefficients,
            covariance: left.inverse,
            variances,
            steps_inverse: steps.inverse,
        })
    }

    /// Differences and steps less unknowns.
    pub fn freedom(&self) -> f64 {
        let octaves: f64 = self.octaves.iter().map(|octave| octave.count).sum();
        octaves + self.steps.nrows() as f64 - UNKNOWNS as f64
    }

    /// The noise of a given form in the size that fits best, with its cost.
    pub fn scaled(&self, noise: Noise) -> Result<(Noise, f64), Error> {
        let found = self.solve(&noise)?;
        let freedom = self.freedom();
        let scale = found.squares / freedom;
        let cost = found.cost - found.squares + freedom * (scale.ln() + 1.0);
        Ok((Noise { amplitude: noise.amplitude * scale, white: noise.white * scale, ..noise }, cost))
    }

    /// Gradient of the cost and Fisher information of (ln a, α, ln w).
    pub fn slope(&self, theta: [f64; 3], at: &Solution) -> Slope {
        let noise = Noise::of(theta);
        let (white, white_steps) = self.white();
        let (flicker, flicker_steps) = self.power_law(noise.exponent);
        let [above, below] = [SMALL, -SMALL].map(|small| self.power_law(noise.exponent + small));
        let bend: Vec<f64> = above.0.iter().zip(&below.0).map(|(a, b)| (a - b) / (2.0 * SMALL)).collect();
        let bend_steps = (above.1 - below.1) * faer::Scale(0.5 / SMALL);
        let parts = [
            (noise.amplitude, flicker, flicker_steps),
            (noise.amplitude, bend, bend_steps),
            (noise.white, white, white_steps),
        ];
        let of = |size: f64, octaves: &[f64]| {
            octaves.iter().zip(&at.variances).map(|(v, all)| size * v / all).collect()
        };
        let relative: [Vec<f64>; 3] = parts.each_ref().map(|(size, octaves, _)| of(*size, octaves));
        let steps = parts.map(|(size, _, steps)| steps * faer::Scale(size));
        let rows = self.steps.nrows();
        let known = Mat::from_fn(rows, UNKNOWNS, |i, j| self.steps[(i, j)]);
        let rest = Mat::from_fn(rows, 1, |i, _| {
            let explained: f64 = (0..UNKNOWNS).map(|j| self.steps[(i, j)] * at.coefficients[j]).sum();
            self.steps[(i, UNKNOWNS)] - explained
        });
        let (u, q) = (&at.steps_inverse * &known, &at.steps_inverse * &rest);
        let shares = steps.each_ref().map(|steps| &at.steps_inverse * steps);
        let octave_sum = |factor: &dyn Fn(usize) -> f64| {
            Mat::from_fn(UNKNOWNS, UNKNOWNS, |i, j| {
                let term =
                    |(n, octave): (usize, &Octave)| octave.products[i][j] / at.variances[n] * factor(n);
                self.octaves.iter().enumerate().map(term).sum::<f64>()
            })
        };
        let through = steps.each_ref().map(|steps| steps * &u);
        let moved: Vec<Mat<f64>> = (0..3)
            .map(|k| &at.covariance * (octave_sum(&|n| relative[k][n]) + u.transpose() * &through[k]))
            .collect();
        let squares: Vec<f64> = self.octaves.iter().map(|octave| octave.squares(&at.coefficients)).collect();
        let gradient = std::array::from_fn(|k| {
            let octaves: f64 = (0..self.octaves.len())
                .map(|n| relative[k][n] * (self.octaves[n].count - squares[n] / at.variances[n]))
                .sum();
            let slow = (q.transpose() * &steps[k] * &q)[(0, 0)];
            octaves + trace(&shares[k]) - slow - trace(&moved[k])
        });
        let information = Mat::from_fn(3, 3, |k, l| {
            let octaves: f64 = (0..self.octaves.len())
                .map(|n| relative[k][n] * relative[l][n] * self.octaves[n].count)
                .sum();
            let both = octave_sum(&|n| relative[k][n] * relative[l][n])
                + through[k].transpose() * &at.steps_inverse * &through[l];
            let taken = 2.0 * trace_of(&at.covariance, &both) - trace_of(&moved[k], &moved[l]);
            0.5 * (octaves + trace_of(&shares[k], &shares[l]) - taken)
        });
        Slope { gradient, information, relative }
    }

    /// What the differences' independence leaves out under a noise.
    pub fn memory(&self, noise: &Noise) -> Memory {
        let flicker = power_law_variances(noise.exponent, self.octaves.len());
        Memory::of(self.octaves, &flicker.iter().map(|v| noise.amplitude * v).collect::<Vec<_>>())
    }

    /// Covariance of the noise between cross products of the reference's columns with T: XᵀVX, and XᵀX, over
    /// the octaves and stretches.
    pub fn sandwich(&self, solution: &Solution, noise: &Noise) -> (Mat<f64>, Mat<f64>) {
        let sum = |factor: &dyn Fn(usize, f64) -> f64| {
            Mat::from_fn(3, 3, |i, j| {
                let term = |(n, octave): (usize, &Octave)| octave.products[i][j] * factor(n, length(n) / 2.0);
                self.octaves.iter().enumerate().map(term).sum::<f64>()
            })
        };
        let weights = self.slow.weights(&[1, 2, 3]);
        let steps = Mat::from_fn(self.steps.nrows(), 3, |i, j| self.steps[(i, j)]);
        let plain = sum(&|_, weight| weight) + weights.transpose() * &steps;
        let noisy = sum(&|n, weight| weight * weight * solution.variances[n])
            + weights.transpose() * self.model(noise).1 * &weights
            + self.memory(noise).products(|n| length(n) / 2.0);
        (plain, noisy)
    }
}

fn trace(matrix: &Mat<f64>) -> f64 {
    (0..matrix.nrows()).map(|i| matrix[(i, i)]).sum()
}

/// tr(A B).
fn trace_of(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
    (0..a.nrows()).map(|i| (0..a.ncols()).map(|j| a[(i, j)] * b[(j, i)]).sum::<f64>()).sum()
}
