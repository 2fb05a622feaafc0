//! Linear least squares of values whose own errors are known and that wander besides, by an unknown amount.

use faer::{Mat, MatRef};

use crate::correlated::log_determinant;
use crate::mixture::Component;
use crate::positive::eigen;
use crate::{Error, linear, linear::LinearFit};

/// y = X β + e + w: the own errors e have the covariance s D, D diagonal and s not below one; the wander w
/// has q K, where K over D has the mean one.
///
/// D^-½ K D^-½ = U Λ Uᵀ. Turned by Uᵀ D^-½ every covariance of the family is diagonal, s + q λ_i, so that
/// each s and q costs a weighted fit and no decomposition.
pub struct Wander {
    design: Mat<f64>,
    y: Vec<f64>,
    eigenvalues: Vec<f64>,
    scale: f64,
}

impl Wander {
    /// For variances D above zero and a covariance of the wander in any scale, rows of rows.
    pub fn of(design: MatRef<'_, f64>, y: &[f64], own: &[f64], wander: &[f64]) -> Result<Self, Error> {
        let rows = y.len();
        let relative = |i: usize, j: usize| wander[i * rows + j] / (own[i] * own[j]).sqrt();
        let scale = (0..rows).map(|i| relative(i, i)).sum::<f64>() / rows as f64;
        let matrix = Mat::from_fn(rows, rows, |i, j| relative(i, j) / scale);
        let (values, directions) = eigen(matrix.as_ref())?;
        let turned = |column: &dyn Fn(usize) -> f64| {
            let white = Mat::from_fn(rows, 1, |i, _| column(i) / own[i].sqrt());
            directions.transpose() * white
        };
        let columns: Vec<Mat<f64>> = (0..design.ncols()).map(|j| turned(&|i| design[(i, j)])).collect();
        Ok(Self {
            design: Mat::from_fn(rows, design.ncols(), |i, j| columns[j][(i, 0)]),
            y: turned(&|i| y[i]).col_as_slice(0).to_vec(),
            eigenvalues: values.iter().map(|value| value.max(0.0)).collect(),
            scale,
        })
    }

    /// The factor from q to the covariance that was given: q K is q/`scale` times that.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The fit for one s and q, weighed by its restricted likelihood, −½ (ln|V| + ln|Xᵀ V⁻¹ X| + r' V⁻¹ r).
    pub fn fit(&self, own: f64, wander: f64) -> Result<Component, Error> {
        let (variances, fit) = self.weighted(own, wander)?;
        let logarithm: f64 = variances.iter().map(|variance| variance.ln()).sum();
        Ok(Component {
            log_weight: -0.5 * (logarithm - log_determinant(&fit.covariance) + fit.sum_of_squares),
            coefficients: fit.coefficients,
            covariance: fit.covariance,
        })
    }

    /// The reference prior of q at s = 1, up to a constant: the root of its Fisher information in the
    /// restricted likelihood, √tr (P K)², P = V⁻¹ − V⁻¹ X (Xᵀ V⁻¹ X)⁻¹ Xᵀ V⁻¹ (Berger, De Oliveira and Sansó
    /// 2001, J. Am. Stat. Assoc. 96, 1361).
    pub fn reference_prior(&self, wander: f64) -> Result<f64, Error> {
        let (variances, LinearFit { covariance, .. }) = self.weighted(1.0, wander)?;
        let unknowns = self.design.ncols();
        let share: Vec<f64> = self.eigenvalues.iter().zip(&variances).map(|(l, v)| l / v).collect();
        // Xᵀ V⁻¹ (K V⁻¹)^power X.
        let between = |power: i32| {
            Mat::from_fn(unknowns, unknowns, |i, j| {
                let rows = 0..variances.len();
                let row = |at: usize| {
                    self.design[(at, i)] * self.design[(at, j)] * share[at].powi(power) / variances[at]
                };
                rows.map(row).sum::<f64>()
            })
        };
        let once = &covariance * between(1);
        let trace = |matrix: &Mat<f64>| (0..unknowns).map(|i| matrix[(i, i)]).sum::<f64>();
        let all: f64 = share.iter().map(|share| share * share).sum();
        let seen = all - 2.0 * trace(&(&covariance * between(2))) + trace(&(&once * &once));
        Ok(seen.max(0.0).sqrt())
    }

    /// The variances of the turned values, and the fit that they weigh.
    fn weighted(&self, own: f64, wander: f64) -> Result<(Vec<f64>, LinearFit), Error> {
        let variances: Vec<f64> = self.eigenvalues.iter().map(|value| own + wander * value).collect();
        let std: Vec<f64> = variances.iter().map(|variance| variance.sqrt()).collect();
        Ok((variances, linear::fit(self.design.as_ref(), &self.y, Some(&std))?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlated::{self, Scale, Whitening};
    use crate::positive::Positive;

    /// Rows, q, own variances, the design of a line, and the covariance of a walk.
    fn setup() -> (usize, f64, Vec<f64>, Mat<f64>, Vec<f64>) {
        let rows = 14;
        let own = (0..rows).map(|i| 0.5 + 0.1 * i as f64).collect();
        let design = Mat::from_fn(rows, 2, |i, j| if j == 0 { 1.0 } else { i as f64 / 10.0 });
        let walk = (0..rows * rows).map(|at| 3.0 * (at / rows).min(at % rows) as f64).collect();
        (rows, 2.5, own, design, walk)
    }

    #[test]
    fn turned_and_whole_covariances_fit_alike() {
        let (rows, q, own, design, walk) = setup();
        let y: Vec<f64> = (0..rows).map(|i| ((i * 7) % 5) as f64 + 0.3 * i as f64).collect();
        let wander = Wander::of(design.as_ref(), &y, &own, &walk).expect("turned");
        let s = 1.7;
        let found = wander.fit(s, q).expect("a fit");
        let other = wander.fit(1.0, 0.4).expect("a fit");
        let whole = |s: f64, q: f64| {
            let entry = |i: usize, j: usize| {
                q / wander.scale() * walk[i * rows + j] + if i == j { s * own[i] } else { 0.0 }
            };
            Whitening::of(&[Mat::from_fn(rows, rows, entry)]).expect("a factor")
        };
        let one = correlated::fit(design.as_ref(), &y, &[whole(s, q)], Scale::Known).expect("a fit");
        for i in 0..2 {
            assert!((found.coefficients[i] - one.coefficients[i]).abs() < 1e-10);
            assert!((found.covariance[(i, i)] / one.covariance(i, i) - 1.0).abs() < 1e-10);
        }
        // Likelihoods agree up to a constant.
        let both = [whole(s, q), whole(1.0, 0.4)];
        let both = correlated::fit(design.as_ref(), &y, &both, Scale::Known).expect("a fit").mixture;
        let straight = (both.weights()[0] / both.weights()[1]).ln();
        assert!((found.log_weight - other.log_weight - straight).abs() < 1e-9, "{straight}");
    }

    #[test]
    fn the_reference_prior_is_the_information_of_the_likelihood() {
        // √tr (P K)² of whole matrices.
        let (rows, q, own, design, walk) = setup();
        let wander = Wander::of(design.as_ref(), &vec![0.0; rows], &own, &walk).expect("turned");
        let k = Mat::from_fn(rows, rows, |i, j| walk[i * rows + j] / wander.scale());
        let entry = |i: usize, j: usize| q * k[(i, j)] + if i == j { own[i] } else { 0.0 };
        let inverse = |matrix: &Mat<f64>| Positive::of(matrix).expect("positive").inverse;
        let v = inverse(&Mat::from_fn(rows, rows, entry));
        let p = &v - &v * &design * inverse(&(design.transpose() * &v * &design)) * design.transpose() * &v;
        let square = &p * &k * &p * &k;
        let trace: f64 = (0..rows).map(|i| square[(i, i)]).sum();
        let prior = wander.reference_prior(q).expect("a prior");
        assert!((prior / trace.sqrt() - 1.0).abs() < 1e-9, "{prior} {trace}");
    }
}
