//! Noise and coefficients of greatest restricted likelihood, and how sure they are.

use estimate::haar::power_law_variances;
use estimate::line_search::halved;
use estimate::positive::Positive;
use faer::Mat;

use super::memory::Memory;
use super::noise::{Noise, Problem, SMALL, Slope, Solution};
use crate::Error;
use crate::octave::UNKNOWNS;

const EXPONENTS: [f64; 2] = [0.1, 2.6];
/// Exponents and decades of the flicker's share at one sample from which the search starts.
const STARTS: [f64; 4] = [0.5, 1.0, 1.5, 2.2];
const DECADES: [i32; 8] = [1, 0, -1, -2, -3, -4, -5, -6];
const FOLLOWED: usize = 2;
/// White noise may be as small as this share of the variance.
const LEAST_WHITE: f64 = 1e-9;
const MOST_STEPS: usize = 60;
const MOST_HALVINGS: i32 = 20;
/// Longest step in the exponent, and in a logarithm.
const LONGEST: [f64; 3] = [2.0, 0.4, 2.0];
/// A step that gains less than this is the last one.
const LAST: f64 = 1e-9;
/// Twice the gain in log likelihood that flicker has to bring, as [`estimate::whittle`] has it.
const FLICKER: f64 = 7.7;

pub struct FittedNoise {
    /// The noise; amplitude 0 where flicker is not significant (1 %).
    pub noise: Noise,
    /// Covariance of (ln a, α, ln w), zero for what is held.
    pub covariance: Mat<f64>,
    /// Standard uncertainty of ln w, also where w is held at its limit.
    pub white_log_std: f64,
    /// Covariance of the coefficients, the differences' covariances counted.
    pub coefficients: Mat<f64>,
    pub solution: Solution,
    /// For each coefficient the degrees of freedom that its uncertainty has, the noise being estimated:
    /// 2/Var(ln σ²) (F. E. Satterthwaite, Biometrics 2 (1946) 110).
    pub freedom: Vec<f64>,
}

impl Problem<'_> {
    /// Greatest likelihood from a start, by steps of the Fisher information within the limits.
    fn climb(&self, start: Noise, least_white: f64) -> Result<([f64; 3], Solution), Error> {
        let limits = [[f64::NEG_INFINITY, f64::INFINITY], EXPONENTS, [least_white.ln(), f64::INFINITY]];
        let mut theta = [start.amplitude.ln(), start.exponent, start.white.ln()];
        let mut at = self.solve(&Noise::of(theta))?;
        for _ in 0..MOST_STEPS {
            let slope = self.slope(theta, &at);
            let free = free(&theta, &limits, &slope.gradient);
            let inverse = within(&slope.information, &free)?;
            let step: [f64; 3] = std::array::from_fn(|i| {
                -0.5 * (0..3).map(|j| inverse[(i, j)] * slope.gradient[j]).sum::<f64>()
            });
            let gain: f64 = -(0..3).map(|i| step[i] * slope.gradient[i]).sum::<f64>();
            if gain < LAST {
                break;
            }
            let shrink = (0..3).map(|i| LONGEST[i] / step[i].abs()).fold(1.0, f64::min);
            let better = halved(MOST_HALVINGS, |share| {
                let next: [f64; 3] = std::array::from_fn(|i| {
                    (theta[i] + share * shrink * step[i]).clamp(limits[i][0], limits[i][1])
                });
                let found = self.solve(&Noise::of(next)).ok()?;
                (found.cost < at.cost).then_some((next, found))
            });
            let Some((next, found)) = better else { break };
            (theta, at) = (next, found);
        }
        Ok((theta, at))
    }

    /// Noise and coefficients of greatest restricted likelihood; flicker only where it is significant.
    pub fn fit(&self) -> Result<FittedNoise, Error> {
        let (white, white_cost) = self.scaled(Noise { amplitude: 0.0, exponent: 1.0, white: 1.0 })?;
        let mut starts: Vec<(Noise, f64)> = Vec::new();
        for exponent in STARTS {
            let first = power_law_variances(exponent, 1)[0];
            for decade in DECADES {
                let amplitude = 2.0 * 10_f64.powi(decade) / first;
                // A form so steep that its covariance cannot be inverted is no start.
                starts.extend(self.scaled(Noise { amplitude, exponent, white: 1.0 }).ok());
            }
        }
        starts.sort_by(|a, b| a.1.total_cmp(&b.1));
        let least_white = LEAST_WHITE * white.white;
        let mut best: Option<([f64; 3], Solution)> = None;
        for (start, _) in starts.into_iter().take(FOLLOWED) {
            let found = self.climb(start, least_white)?;
            if best.as_ref().is_none_or(|best| found.1.cost < best.1.cost) {
                best = Some(found);
            }
        }
        let Some((theta, solution)) = best.filter(|(_, best)| white_cost - best.cost > FLICKER) else {
            let (freedom, solution) = (self.freedom(), self.solve(&white)?);
            let mut covariance = Mat::zeros(3, 3);
            covariance[(2, 2)] = 2.0 / freedom;
            return Ok(FittedNoise {
                noise: white,
                covariance,
                white_log_std: (2.0 / freedom).sqrt(),
                coefficients: solution.covariance.clone(),
                solution,
                freedom: vec![freedom; UNKNOWNS],
            });
        };
        let Slope { information, relative, .. } = self.slope(theta, &solution);
        let held =
            [false, theta[1] <= EXPONENTS[0] || theta[1] >= EXPONENTS[1], theta[2] <= least_white.ln()];
        let noise = Noise::of(theta);
        let memory = self.memory(&noise);
        let inverse = within(&information, &held.map(|held| !held))?;
        let covariance = &inverse + &inverse * scores(&memory, &relative, &solution.variances) * &inverse;
        let freedom = self.satterthwaite(theta, &solution, &covariance)?;
        let left_out = memory.products(|n| 1.0 / solution.variances[n]);
        let left_out =
            Mat::from_fn(UNKNOWNS, UNKNOWNS, |i, j| if i.max(j) < 3 { left_out[(i, j)] } else { 0.0 });
        let coefficients = &solution.covariance + &solution.covariance * left_out * &solution.covariance;
        let white_log_std = if held[2] { information[(2, 2)].powf(-0.5) } else { covariance[(2, 2)].sqrt() };
        Ok(FittedNoise { noise, covariance, white_log_std, coefficients, solution, freedom })
    }

    fn satterthwaite(
        &self,
        theta: [f64; 3],
        at: &Solution,
        covariance: &Mat<f64>,
    ) -> Result<Vec<f64>, Error> {
        let mut slopes = Mat::<f64>::zeros(3, UNKNOWNS);
        for k in (0..3).filter(|k| covariance[(*k, *k)] > 0.0) {
            let mut moved = theta;
            moved[k] += SMALL;
            let moved = self.solve(&Noise::of(moved))?.covariance;
            for i in 0..UNKNOWNS {
                slopes[(k, i)] = (moved[(i, i)] / at.covariance[(i, i)]).ln() / SMALL;
            }
        }
        let variance = slopes.transpose() * covariance * &slopes;
        Ok((0..UNKNOWNS).map(|i| 2.0 / variance[(i, i)]).collect())
    }
}

/// What the covariances of the differences add to the covariance of the likelihood's derivatives:
/// ½ Σ ∂_k ln V_i ∂_l ln V_j Cov(e_i, e_j)²/(V_i V_j).
fn scores(memory: &Memory, relative: &[Vec<f64>], variances: &[f64]) -> Mat<f64> {
    let mut sum = Mat::zeros(3, 3);
    for pair in memory.pairs() {
        let (i, j) = (pair.lower, pair.upper);
        let factor = 0.25 * pair.count * pair.noise.powi(2) / (variances[i] * variances[j]);
        for k in 0..3 {
            for l in 0..3 {
                sum[(k, l)] += factor * (relative[k][i] * relative[l][j] + relative[k][j] * relative[l][i]);
            }
        }
    }
    sum
}

/// Which unknowns may move: not those at a limit that the gradient pushes against.
fn free(theta: &[f64; 3], limits: &[[f64; 2]; 3], gradient: &[f64; 3]) -> [bool; 3] {
    std::array::from_fn(|i| {
        !(theta[i] <= limits[i][0] && gradient[i] > 0.0 || theta[i] >= limits[i][1] && gradient[i] < 0.0)
    })
}

/// The inverse of the part of a matrix that is free, zero elsewhere.
fn within(matrix: &Mat<f64>, free: &[bool; 3]) -> Result<Mat<f64>, Error> {
    let places: Vec<usize> = (0..3).filter(|i| free[*i]).collect();
    let inverse =
        Positive::of(&Mat::from_fn(places.len(), places.len(), |i, j| matrix[(places[i], places[j])]))?
            .inverse;
    let mut all = Mat::zeros(3, 3);
    for (i, to) in places.iter().enumerate() {
        for (j, other) in places.iter().enumerate() {
            all[(*to, *other)] = inverse[(i, j)];
        }
    }
    Ok(all)
}
