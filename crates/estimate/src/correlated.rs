//! Linear least squares of readings whose errors are correlated (generalised least squares).

use faer::linalg::solvers::Llt;
use faer::{ColRef, Mat, MatMut, MatRef};
use rayon::prelude::*;
use std::sync::Arc;

use crate::Error;
use crate::gauss_newton::Linear;
use crate::linear::{self, LinearFit};
use crate::mixture::{Component, Mixture};
use crate::positive::{Positive, cholesky};
use crate::svd::Svd;

/// Combinations of unknowns count as shown down to this share of the largest singular value.
const SHOWN: f64 = 1e-12;

/// What makes the readings of one group independent: L⁻¹, for their covariance V = L Lᵀ.
pub trait Root: std::fmt::Debug + Send + Sync {
    /// How many readings.
    fn rows(&self) -> usize;

    /// ln |V|.
    fn log_determinant(&self) -> f64;

    /// Puts L⁻¹ of each column in its place.
    fn whiten(&self, columns: MatMut<'_, f64>);
}

impl Root for Llt<f64> {
    fn rows(&self) -> usize {
        self.L().nrows()
    }

    fn log_determinant(&self) -> f64 {
        (0..self.rows()).map(|i| 2.0 * self.L()[(i, i)].ln()).sum()
    }

    fn whiten(&self, columns: MatMut<'_, f64>) {
        self.L().solve_lower_triangular_in_place(columns);
    }
}

/// Whitening transform of correlated readings, group by group: groups share nothing.
#[derive(Clone, Debug)]
pub struct Whitening {
    groups: Vec<Arc<dyn Root>>,
    /// A factor of each group's standard deviations.
    scales: Vec<f64>,
    /// ln |V|.
    log_determinant: f64,
    /// ln of its probability beforehand, up to a constant.
    log_prior: f64,
}

impl Whitening {
    /// Of the covariance of each group of readings, which must be positive definite.
    pub fn of(covariances: &[Mat<f64>]) -> Result<Self, Error> {
        let root = |covariance: &Mat<f64>| Ok(Arc::new(cholesky(covariance.as_ref())?) as Arc<dyn Root>);
        Ok(Self::by(covariances.iter().map(root).collect::<Result<_, Error>>()?))
    }

    /// By what makes each group of readings independent.
    pub fn by(groups: Vec<Arc<dyn Root>>) -> Self {
        let log_determinant = groups.iter().map(|group| group.log_determinant()).sum();
        Self { scales: vec![1.0; groups.len()], groups, log_determinant, log_prior: 0.0 }
    }

    /// The same with the standard deviations of each group times a factor.
    pub fn scaled(&self, scales: &[f64]) -> Self {
        let mut scaled = self.clone();
        for ((group, own), scale) in self.groups.iter().zip(&mut scaled.scales).zip(scales) {
            *own *= scale;
            scaled.log_determinant += 2.0 * group.rows() as f64 * scale.ln();
        }
        scaled
    }

    /// The same with a probability beforehand, up to a factor that is common to all.
    #[must_use]
    pub fn weighing(self, prior: f64) -> Self {
        Self { log_prior: prior.ln(), ..self }
    }

    /// L⁻¹ A.
    pub fn apply(&self, matrix: MatRef<'_, f64>) -> Mat<f64> {
        let mut white = matrix.to_owned();
        let mut from = 0;
        for (group, scale) in self.groups.iter().zip(&self.scales) {
            let rows = group.rows();
            let mut part = white.as_mut().subrows_mut(from, rows);
            group.whiten(part.as_mut());
            part.col_iter_mut().flat_map(|column| column.iter_mut()).for_each(|value| *value /= scale);
            from += rows;
        }
        white
    }

    /// L⁻¹ y.
    pub fn apply_to(&self, values: &[f64]) -> Vec<f64> {
        self.apply(MatRef::from_column_major_slice(values, values.len(), 1)).col_as_slice(0).to_vec()
    }
}

/// What is known of the size of a covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Known up to a factor, which the residuals give.
    Fitted,
    /// Known as it stands.
    Known,
}

/// A linear fit of readings whose covariance is known, perhaps up to a factor, or is one of several.
#[derive(Clone, Debug)]
pub struct CorrelatedFit {
    /// The coefficients.
    pub coefficients: Vec<f64>,
    /// y − X β.
    pub residuals: Vec<f64>,
    /// The largest of X β.
    pub largest: f64,
    /// The residuals made independent, over their common standard deviation: of the likeliest covariance.
    pub whitened: Vec<f64>,
    /// Σ of the squared whitened residuals over the degrees of freedom: 1 where the covariance is right.
    pub variance_factor: f64,
    /// Rows less rank.
    pub freedom: f64,
    /// Rank of the design.
    pub rank: usize,
    /// The coefficients under each covariance, with their probabilities, from which intervals are made.
    pub mixture: Mixture,
}

impl CorrelatedFit {
    /// An element of the covariance; of several models scaled so that a standard uncertainty times Student's
    /// factor is the half-width of the interval that holds the coefficient with 95 %.
    pub fn covariance(&self, i: usize, j: usize) -> f64 {
        self.mixture.covered(i, j)
    }
}

/// A step of the mean under all covariances: no one sum of squares damps it, so it is shortened.
impl Linear for CorrelatedFit {
    fn step(&self, damping: f64) -> Vec<f64> {
        self.coefficients.iter().map(|coefficient| coefficient / (1.0 + damping)).collect()
    }

    fn shift(&self, damping: f64) -> f64 {
        self.largest / (1.0 + damping)
    }

    fn rank(&self) -> usize {
        self.rank
    }
}

/// Fits y ≈ X β under one of several covariances.
///
/// For each that is known up to a factor, the factor is s² = r' V⁻¹ r/(n − p). Where there are several they
/// are averaged by their restricted likelihood, −½ (ln|V| + ln|Xᵀ V⁻¹ X| + (n − p) ln r' V⁻¹ r), or with r'
/// V⁻¹ r in place of the last term where they are known as they stand, times what each weighs beforehand: an
/// interval does not rest on the one that happens to be likeliest. With one covariance this is generalised
/// least squares, and Student's t with n − p degrees of freedom is exact. Of a design that does not show all
/// unknowns, the determinant is that of the combinations that it shows: the same under every covariance.
pub fn fit(
    design: MatRef<'_, f64>,
    y: &[f64],
    covariances: &[Whitening],
    scale: Scale,
) -> Result<CorrelatedFit, Error> {
    let unknowns = design.ncols();
    let whitened =
        |whitening: &Whitening| linear::fit(whitening.apply(design).as_ref(), &whitening.apply_to(y), None);
    let fits: Vec<LinearFit> = covariances.par_iter().map(whitened).collect::<Result<_, Error>>()?;
    let shown = if fits.iter().any(|fit| fit.rank < unknowns) { Some(shown(design)?) } else { None };
    let component = |(whitening, fit): (&Whitening, &LinearFit)| {
        let (misfit, size) = match scale {
            Scale::Fitted => (
                fit.freedom * fit.sum_of_squares.max(f64::MIN_POSITIVE).ln(),
                fit.sum_of_squares / fit.freedom,
            ),
            Scale::Known => (fit.sum_of_squares, 1.0),
        };
        let determinant = match &shown {
            Some(shown) => log_determinant(&(shown * &fit.covariance * shown.transpose())),
            None => log_determinant(&fit.covariance),
        };
        Component {
            log_weight: whitening.log_prior - 0.5 * (whitening.log_determinant - determinant + misfit),
            coefficients: fit.coefficients.clone(),
            covariance: Mat::from_fn(unknowns, unknowns, |i, j| size * fit.covariance[(i, j)]),
        }
    };
    let components: Vec<Component> = covariances.iter().zip(&fits).map(component).collect();
    let likelihood = |at: &usize| components[*at].log_weight;
    let best = (0..fits.len())
        .max_by(|a, b| likelihood(a).total_cmp(&likelihood(b)))
        .ok_or(Error::TooFew { found: 0, unknowns })?;
    let freedom = match scale {
        Scale::Fitted => fits[best].freedom,
        Scale::Known => f64::INFINITY,
    };
    let mixture = Mixture::of(components, freedom);
    let coefficients = mixture.coefficients().to_vec();
    let left = ColRef::from_slice(y) - design * ColRef::from_slice(&coefficients);
    let residuals: Vec<f64> = left.iter().copied().collect();
    let likeliest = &fits[best];
    let variance_factor = likeliest.sum_of_squares / likeliest.freedom;
    let std = variance_factor.sqrt();
    Ok(CorrelatedFit {
        largest: y.iter().zip(&residuals).map(|(y, left)| (y - left).abs()).fold(0.0, f64::max),
        coefficients,
        residuals,
        whitened: likeliest.residuals.iter().map(|r| if std > 0.0 { r / std } else { 0.0 }).collect(),
        variance_factor,
        freedom: likeliest.freedom,
        rank: likeliest.rank,
        mixture,
    })
}

/// The combinations of unknowns that a design shows, a row for each.
fn shown(design: MatRef<'_, f64>) -> Result<Mat<f64>, Error> {
    let svd = Svd::of(design, SHOWN)?;
    let directions = svd.directions();
    Ok(Mat::from_fn(svd.rank(), design.ncols(), |i, j| directions[(j, i)] * svd.lengths()[j]))
}

/// ln |C| of a covariance; of one that rounding leaves singular, as if its elements were independent.
pub(crate) fn log_determinant(covariance: &Mat<f64>) -> f64 {
    let independent = || covariance.diagonal().column_vector().iter().map(|variance| variance.ln()).sum();
    Positive::of(covariance).map_or_else(|_| independent(), |positive| positive.log_determinant)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn independent_errors_give_the_linear_fit() {
        let design = Mat::from_fn(12, 2, |i, j| if j == 0 { 1.0 } else { i as f64 });
        let y: Vec<f64> = (0..12).map(|i| 3.0 + 0.5 * f64::from(i) + f64::from(i * i % 5)).collect();
        let white =
            Whitening::of(&[Mat::from_fn(12, 12, |i, j| if i == j { 4.0 } else { 0.0 })]).expect("a factor");
        let one = fit(design.as_ref(), &y, std::slice::from_ref(&white), Scale::Fitted).expect("a fit");
        let plain = linear::fit(design.as_ref(), &y, None).expect("a fit");
        for k in 0..2 {
            assert!((one.coefficients[k] - plain.coefficients[k]).abs() < 1e-12);
            let variance = plain.covariance[(k, k)] * plain.sum_of_squares / plain.freedom;
            assert!((one.covariance(k, k) / variance - 1.0).abs() < 1e-12);
        }
        assert!((one.variance_factor - plain.sum_of_squares / plain.freedom / 4.0).abs() < 1e-12);
        // The same twice weighs alike and changes nothing.
        let two = fit(design.as_ref(), &y, &[white.clone(), white], Scale::Fitted).expect("a fit");
        assert!((two.mixture.weights()[0] - 0.5).abs() < 1e-12);
        assert!((two.covariance(1, 1) - one.covariance(1, 1)).abs() < 1e-15);
    }

    #[test]
    fn a_column_that_adds_nothing_changes_no_weight() {
        let wide = Mat::from_fn(60, 3, |i, j| [1.0, i as f64, 15.0 * i as f64][j]);
        let y: Vec<f64> = (0..60).map(|i| 0.2 * f64::from(i) + f64::from(i * i % 7)).collect();
        let covariances: Vec<Whitening> = [0.0, 0.5, 0.9]
            .map(|memory: f64| Mat::from_fn(60, 60, |i, j| memory.powi(i.abs_diff(j) as i32)))
            .map(|covariance| Whitening::of(&[covariance]).expect("a factor"))
            .to_vec();
        let [one, both] = [wide.get(.., ..2), wide.as_ref()]
            .map(|design| fit(design, &y, &covariances, Scale::Fitted).expect("a fit"));
        assert_eq!((one.rank, both.rank), (2, 2));
        for (a, b) in one.mixture.weights().iter().zip(both.mixture.weights()) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
        for (a, b) in one.residuals.iter().zip(&both.residuals) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}
