//! Coefficients under several models at once, each model with its probability.

use faer::Mat;
use faer::linalg::solvers::Solve;
use statrs::distribution::{Continuous, ContinuousCDF, Normal, StudentsT};
use std::sync::OnceLock;

use crate::positive::cholesky;
use crate::{Error, stats};

/// Probability of the intervals that covariances are scaled to.
const COVERED: f64 = 0.95;
/// Components with less weight than this change no digit that is printed.
const NEGLIGIBLE: f64 = 1e-12;
/// Steps to a half-width at most, and its relative accuracy.
const MOST_STEPS: usize = 60;
const ACCURACY: f64 = 1e-10;
/// After a Newton step that is so short, as a share, the rest is below that: it goes with the square.
const SHORT: f64 = 1e-6;

/// What one model says.
#[derive(Clone, Debug)]
pub struct Component {
    /// ln of prior times likelihood, up to a constant that is common to all models.
    pub log_weight: f64,
    /// Its coefficients.
    pub coefficients: Vec<f64>,
    /// Their covariance.
    pub covariance: Mat<f64>,
}

/// The posterior Σ w_m t_ν(β_m, C_m): Bayesian model averaging (Hoeting et al. 1999, Statist. Sci. 14, 382).
///
/// Intervals are those of the mixture itself: where one model in five makes a coefficient ten times less
/// certain, the tails hold more than those of a normal distribution of the same variance.
#[derive(Clone, Debug)]
pub struct Mixture {
    components: Vec<Component>,
    weights: Vec<f64>,
    freedom: f64,
    mean: Vec<f64>,
    /// Of each coefficient, once it is asked for: the interval over that of Student's factor alone.
    wider: Vec<OnceLock<f64>>,
}

impl Mixture {
    /// Of at least one model; ν degrees of freedom in each, infinite for normal distributions.
    pub fn of(components: Vec<Component>, freedom: f64) -> Self {
        let largest = components.iter().map(|one| one.log_weight).fold(f64::NEG_INFINITY, f64::max);
        let relative: Vec<f64> = components.iter().map(|one| (one.log_weight - largest).exp()).collect();
        let sum: f64 = relative.iter().sum();
        // Of one model the weight is one, whatever its likelihood.
        let weights =
            if relative.len() == 1 { vec![1.0] } else { relative.iter().map(|r| r / sum).collect() };
        let unknowns = components.first().map_or(0, |one| one.coefficients.len());
        let mut mixture = Self { components, weights, freedom, mean: Vec::new(), wider: Vec::new() };
        let of = |at: usize| mixture.weighty().map(|(one, weight)| weight * one.coefficients[at]).sum();
        mixture.mean = (0..unknowns).map(of).collect();
        mixture.wider = vec![OnceLock::new(); unknowns];
        mixture
    }

    /// Probability of each model.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Σ w_m β_m.
    pub fn coefficients(&self) -> &[f64] {
        &self.mean
    }

    /// An element of Σ w_m (C_m + (β_m − β)(β_m − β)ᵀ).
    pub fn covariance(&self, i: usize, j: usize) -> f64 {
        let away = |one: &Component, at: usize| one.coefficients[at] - self.mean[at];
        let of = |(one, weight): (&Component, f64)| {
            weight * (one.covariance[(i, j)] + away(one, i) * away(one, j))
        };
        self.weighty().map(of).sum()
    }

    /// The same, scaled so that each std times Student's factor is half the interval of 95 %.
    pub fn covered(&self, i: usize, j: usize) -> f64 {
        let [wider, other] = [i, j].map(|at| {
            let factor = || self.coverage_factor(at, COVERED) / stats::coverage_factor(COVERED, self.freedom);
            self.wider[at].get_or_init(factor)
        });
        wider * other * self.covariance(i, j)
    }

    /// h/u of one coefficient: β ± h holds it with `probability`, u its standard deviation as in
    /// [`Mixture::covariance`]. With one model this is Student's factor.
    pub fn coverage_factor(&self, coefficient: usize, probability: f64) -> f64 {
        let single = stats::coverage_factor(probability, self.freedom);
        // Under each model its weight, the distance from the mean over all, and the standard deviation.
        let part = |(one, weight): (&Component, f64)| {
            let std = one.covariance[(coefficient, coefficient)].max(0.0).sqrt();
            (weight, one.coefficients[coefficient] - self.mean[coefficient], std)
        };
        let parts: Vec<(f64, f64, f64)> = self.weighty().map(part).collect();
        let variance: f64 =
            parts.iter().map(|(weight, away, std)| weight * (std.powi(2) + away.powi(2))).sum();
        if parts.len() < 2 || variance == 0.0 || parts.iter().any(|(.., std)| *std == 0.0) {
            return single;
        }
        // The law of a coefficient under one model, over its standard deviation.
        let student = StudentsT::new(0.0, 1.0, self.freedom).ok();
        let (student, normal) = (student.filter(|_| self.freedom < stats::NORMAL_FROM), Normal::standard());
        let pdf = |at: f64| student.map_or_else(|| normal.pdf(at), |law| law.pdf(at));
        let cdf = |at: f64| student.map_or_else(|| normal.cdf(at), |law| law.cdf(at));
        let far = |(_, away, std): &(f64, f64, f64)| away.abs() + single * std;
        let (mut low, mut high) = (0.0, parts.iter().map(far).fold(0.0, f64::max));
        let mut half = (single * variance.sqrt()).min(high);
        // Newton's steps, or half the bracket where one would leave it.
        for _ in 0..MOST_STEPS {
            let (inside, slope) = parts.iter().fold((0.0, 0.0), |(inside, slope), (weight, away, std)| {
                let [above, below] = [half - away, -half - away].map(|at| at / std);
                let density = (pdf(above) + pdf(below)) / std;
                let held = cdf(above) - cdf(below);
                (inside + weight * held, slope + weight * density)
            });
            if inside < probability {
                low = half
            } else {
                high = half
            }
            let newton = half + (probability - inside) / slope;
            let (next, short) =
                if newton > low && newton < high { (newton, SHORT) } else { (0.5 * (low + high), ACCURACY) };
            let moved = (next - half).abs();
            half = next;
            if moved <= short * half {
                break;
            }
        }
        half / variance.sqrt()
    }

    /// Σ w_m p_m, p_m the probability under a model of such coefficients by chance: F of βᵀ C⁻¹ β/k.
    pub fn p_value(&self, which: &[usize]) -> Result<f64, Error> {
        let count = which.len();
        let of = |(one, weight): (&Component, f64)| {
            let block = Mat::from_fn(count, count, |i, j| one.covariance[(which[i], which[j])]);
            let values = Mat::from_fn(count, 1, |i, _| one.coefficients[which[i]]);
            let solved = cholesky(block.as_ref())?.solve(&values);
            let form: f64 = (0..count).map(|i| values[(i, 0)] * solved[(i, 0)]).sum();
            Ok(weight * stats::f_p(form / count as f64, count as f64, self.freedom))
        };
        self.weighty().map(of).sum()
    }

    fn weighty(&self) -> impl Iterator<Item = (&Component, f64)> {
        let all = self.components.iter().zip(self.weights.iter().copied());
        all.filter(|(_, weight)| *weight > NEGLIGIBLE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn component(weight: f64, value: f64, std: f64) -> Component {
        Component {
            log_weight: weight.ln() - 700.0,
            coefficients: vec![value],
            covariance: Mat::from_fn(1, 1, |_, _| std * std),
        }
    }

    #[test]
    fn one_model_has_student_s_factor() {
        let one = Mixture::of(vec![component(0.3, 2.0, 0.5)], 10.0);
        assert!((one.coverage_factor(0, 0.95) - 2.228_138_85).abs() < 1e-6);
        assert_eq!((one.coefficients()[0], one.weights()[0]), (2.0, 1.0));
        // |t| = 4 with ten degrees of freedom: p = 0.002518.
        assert!((one.p_value(&[0]).expect("p") - 0.002_518).abs() < 1e-6);
        // The same twice changes nothing.
        let twice = Mixture::of(vec![component(0.3, 2.0, 0.5), component(0.1, 2.0, 0.5)], 10.0);
        assert!((twice.coverage_factor(0, 0.95) - 2.228_138_85).abs() < 1e-6);
        assert!((twice.covariance(0, 0) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_mixture_by_hand() {
        // ½ N(0, 1) + ½ N(0, 3²): ½ erfc(h/√2) + ½ erfc(h/(3√2)) = 0.05; the variance is 5.
        let two = Mixture::of(vec![component(0.5, 1.0, 1.0), component(0.5, 1.0, 3.0)], f64::INFINITY);
        let half = two.coverage_factor(0, 0.95) * 5f64.sqrt();
        let outside =
            0.5 * (stats::two_sided_p(half, f64::INFINITY) + stats::two_sided_p(half / 3.0, f64::INFINITY));
        assert!((outside - 0.05).abs() < 1e-9 && (two.covariance(0, 0) - 5.0).abs() < 1e-12);
        let covered = two.covered(0, 0).sqrt() * stats::coverage_factor(0.95, f64::INFINITY);
        assert!((covered - half).abs() < 1e-9);
        // Two values far apart: the interval holds both, and 95 % of all reach into the outer tails of each.
        let apart = Mixture::of(vec![component(0.5, -10.0, 1.0), component(0.5, 10.0, 1.0)], f64::INFINITY);
        let half = apart.coverage_factor(0, 0.95) * 101f64.sqrt();
        assert!((half - 11.644_854).abs() < 1e-6, "{half}");
    }
}
