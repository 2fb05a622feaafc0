//! Linear least squares about a fit, and estimates of several models of the noise averaged.

use estimate::Svd;
use faer::Mat;

use crate::fit::PriorRows;

/// Singular values below this share of the largest count as zero.
pub const RANK_TOLERANCE: f64 = 1e-9;

/// Whitened rows as linear least squares: J δ ≈ r.
pub struct Linear {
    /// J, in a factor.
    pub jacobian: Mat<f64>,
    /// r.
    pub right: Vec<f64>,
}

impl Linear {
    /// Of a factor U whose first column is r, over the standard deviation of a row.
    pub fn of(upper: &Mat<f64>, variance: f64) -> Self {
        let upper = upper * faer::Scale(1.0 / variance.max(f64::MIN_POSITIVE).sqrt());
        let rows = upper.nrows();
        Self {
            jacobian: upper.subcols(1, rows - 1).to_owned(),
            right: (0..rows).map(|i| upper[(i, 0)]).collect(),
        }
    }

    /// With rows of what is known, about a state.
    pub fn with(&self, known: &PriorRows, state: &[f64]) -> Self {
        let rows = self.jacobian.nrows();
        let jacobian = Mat::from_fn(rows + known.len(), self.jacobian.ncols(), |i, j| {
            if i < rows { self.jacobian[(i, j)] } else { known[i - rows].0.get(j).copied().unwrap_or(0.0) }
        });
        let mut right = self.right.clone();
        right.extend(known.iter().map(|(weights, value)| {
            value - weights.iter().zip(state).map(|(weight, value)| weight * value).sum::<f64>()
        }));
        Self { jacobian, right }
    }
}

/// Estimates of several models, averaged by their weights.
#[derive(Default)]
pub struct Mixture {
    steps: Vec<Vec<f64>>,
    weights: Vec<f64>,
    within: Option<Mat<f64>>,
    /// Whether every model determines all parameters.
    pub full: bool,
}

impl Mixture {
    /// Adds the estimate of a model with rows of what is known, about a state.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Fit`] where the decomposition fails.
    pub fn add(
        &mut self,
        weight: f64,
        linear: &Linear,
        known: &PriorRows,
        state: &[f64],
    ) -> Result<(), crate::Error> {
        let linear = linear.with(known, state);
        let svd = Svd::of(linear.jacobian.as_ref(), RANK_TOLERANCE)?;
        let full = svd.rank() == linear.jacobian.ncols();
        self.full = full && (self.full || self.steps.is_empty());
        let covariance = svd.covariance() * faer::Scale(weight);
        self.within = Some(match self.within.take() {
            Some(within) => within + covariance,
            None => covariance,
        });
        self.steps.push(svd.solve(&linear.right));
        self.weights.push(weight);
        Ok(())
    }

    /// The mean step and the covariance.
    pub fn result(&self) -> (Vec<f64>, Mat<f64>) {
        let count = self.steps.first().map_or(0, Vec::len);
        let total: f64 = self.weights.iter().sum();
        let each = || self.steps.iter().zip(&self.weights).map(|(step, weight)| (step, weight / total));
        let mean: Vec<f64> =
            (0..count).map(|j| each().map(|(step, weight)| weight * step[j]).sum()).collect();
        let within = self.within.clone().unwrap_or_else(|| Mat::zeros(count, count));
        let covariance = Mat::from_fn(count, count, |i, j| {
            let between: f64 =
                each().map(|(step, weight)| weight * (step[i] - mean[i]) * (step[j] - mean[j])).sum();
            within[(i, j)] / total + between
        });
        (mean, covariance)
    }
}

/// J with JᵀJ the inverse of a covariance.
pub fn root(covariance: &Mat<f64>) -> Mat<f64> {
    let count = covariance.nrows();
    let scale: Vec<f64> = (0..count).map(|k| covariance[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let correlation = Mat::from_fn(count, count, |i, j| covariance[(i, j)] / (scale[i] * scale[j]));
    let Ok(own) = correlation.self_adjoint_eigen(faer::Side::Lower) else {
        return Mat::zeros(count, count);
    };
    Mat::from_fn(count, count, |k, j| own.U()[(j, k)] / (own.S()[k].max(1e-14).sqrt() * scale[j]))
}
