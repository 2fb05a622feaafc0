//! Linear regression of long even series whose errors have a known spectrum.

use faer::{ColRef, Mat};
use fourier::Complex;

use crate::Error;
use crate::cross_spectrum::transform;
use crate::linear::dot;
use crate::positive::Positive;
use crate::stats::chi_squared_p;

/// Frequencies whose products are summed at once: the numbers of all columns there stay near the processor.
const BLOCK: usize = 256;

/// A regression y ≈ c + X β of n samples Δt apart; the constant is taken off as the mean.
#[derive(Clone, Debug)]
pub struct SpectralFit {
    /// β by least squares.
    pub least_squares: Vec<f64>,
    /// Its covariance under errors of the given spectrum.
    pub covariance: Mat<f64>,
    /// (X°ᵀ X°)⁻¹: its covariance if the errors were independent and of variance one.
    pub independent: Mat<f64>,
    /// β weighted by the spectrum: the estimate of least variance.
    pub weighted: Vec<f64>,
    /// Its covariance.
    pub weighted_covariance: Mat<f64>,
}

/// β weighted by the spectrum alone, with its covariance.
#[derive(Clone, Debug)]
pub struct WeightedFit {
    /// β.
    pub coefficients: Vec<f64>,
    /// Its covariance.
    pub covariance: Mat<f64>,
}

/// Fits y by columns, both less their means, under errors with the one-sided density `density` (the square of
/// y's unit, per Hz).
///
/// With the transforms x̃_k, ỹ_k at f_k = k/(nΔt), k = 1 … n/2, and the errors' variance there, S_k = n
/// P(f_k)/(2Δt):
///
/// - least squares, β = (X°ᵀX°)⁻¹ X°ᵀy°, has the covariance (X°ᵀX°)⁻¹ (X°ᵀ V X°)(X°ᵀX°)⁻¹ with
///   X°ᵀVX° = 2/n Σ x̃_k* x̃_kᵀ P_k/(2Δt): errors with memory are in it;
/// - weighted, β = (Σ x̃_k* x̃_kᵀ/S_k)⁻¹ Σ x̃_k* ỹ_k/S_k (real parts), with the covariance (2 Σ x̃_k*
///   x̃_kᵀ/S_k)⁻¹.
///
/// Errors are taken as periodic over the series, which matters for what is slower than its length.
///
/// Source: E. J. Hannan, Regression for time series, in Time Series Analysis (M. Rosenblatt, ed.), Wiley
/// 1963.
///
/// Errors: [`Error::TooFew`] for fewer samples than twice the columns; [`Error::Decomposition`] where the
/// columns depend on each other.
pub fn regress(
    columns: &[Vec<f64>],
    y: &[f64],
    step_s: f64,
    density: &dyn Fn(f64) -> f64,
) -> Result<SpectralFit, Error> {
    let x: Vec<Transform> = columns.iter().map(|column| Transform::of(column)).collect();
    regress_transforms(&x.iter().collect::<Vec<_>>(), &Transform::of(y), step_s, density)
}

/// The transform of a series less its mean, which may be used in many regressions.
pub struct Transform {
    rows: usize,
    values: Vec<Complex<f64>>,
}

impl Transform {
    /// Of a series.
    pub fn of(series: &[f64]) -> Self {
        Self { rows: series.len(), values: transform(series, None) }
    }

    /// What each frequency of such a series weighs under errors of this density: one over their variance.
    pub fn weights(&self, step_s: f64, density: &dyn Fn(f64) -> f64) -> Vec<f64> {
        self.at_frequencies(step_s, &|f| 2.0 * step_s / density(f))
    }

    /// A function of the frequency at all of them but zero.
    fn at_frequencies(&self, step_s: f64, of: &dyn Fn(f64) -> f64) -> Vec<f64> {
        let length_s = self.rows as f64 * step_s;
        (1..=self.rows / 2).map(|k| of(k as f64 / length_s)).collect()
    }
}

/// The same as [`regress`] of columns and y that are transforms.
///
/// Errors: as [`regress`].
pub fn regress_transforms(
    columns: &[&Transform],
    y: &Transform,
    step_s: f64,
    density: &dyn Fn(f64) -> f64,
) -> Result<SpectralFit, Error> {
    let variances = y.at_frequencies(step_s, &|f| density(f) / (2.0 * step_s));
    let weights: Vec<f64> = variances.iter().map(|variance| variance.recip()).collect();
    let weighted = weighted(columns, y, &weights)?;
    let plain = products(columns, y, &vec![1.0; variances.len()]);
    let noisy = products(columns, y, &variances);
    let independent = Positive::of(&square(&plain))?.inverse;
    Ok(SpectralFit {
        least_squares: solved(&independent, &plain),
        covariance: &independent * &square(&noisy) * &independent,
        weighted: weighted.coefficients,
        weighted_covariance: weighted.covariance,
        independent,
    })
}

/// The weighted fit alone, by the weight of each frequency.
///
/// Errors: as [`regress`].
pub fn weighted(columns: &[&Transform], y: &Transform, weights: &[f64]) -> Result<WeightedFit, Error> {
    let unknowns = columns.len();
    if y.rows < 2 * unknowns + 2 {
        return Err(Error::TooFew { found: y.rows, unknowns });
    }
    let products = products(columns, y, weights);
    let covariance = Positive::of(&square(&products))?.inverse;
    Ok(WeightedFit { coefficients: solved(&covariance, &products), covariance })
}

/// Sums of products of the columns, y as the last of them, over all frequencies but zero, weighted; the lower
/// triangle.
fn products(columns: &[&Transform], y: &Transform, weights: &[f64]) -> Mat<f64> {
    let count = y.rows as f64;
    let all: Vec<&[Complex<f64>]> = columns.iter().copied().chain([y]).map(|of| &of.values[1..]).collect();
    let mut sums: Mat<f64> = Mat::zeros(all.len(), all.len());
    let mut scaled = vec![Vec::with_capacity(2 * BLOCK); all.len()];
    for from in (0..weights.len()).step_by(BLOCK) {
        let block = from..(from + BLOCK).min(weights.len());
        // Bands weigh nothing elsewhere.
        if weights[block.clone()].iter().all(|weight| *weight == 0.0) {
            continue;
        }
        // The Nyquist frequency stands once in the transform, the others twice.
        let share = |row: usize| if 2 * (row + 1) == y.rows { 1.0 } else { 2.0 } / count;
        let roots: Vec<f64> = block.clone().map(|row| (share(row) * weights[row]).sqrt()).collect();
        for (scaled, column) in scaled.iter_mut().zip(&all) {
            scaled.clear();
            let values = column[block.clone()].iter().zip(&roots);
            scaled.extend(values.flat_map(|(x, root)| [x.re * root, x.im * root]));
        }
        for i in 0..all.len() {
            for j in 0..=i {
                sums[(i, j)] += dot(&scaled[i], &scaled[j]);
            }
        }
    }
    sums
}

/// The products of the columns with each other, on both sides of the diagonal.
fn square(products: &Mat<f64>) -> Mat<f64> {
    let unknowns = products.nrows() - 1;
    Mat::from_fn(unknowns, unknowns, |i, j| products[(i.max(j), i.min(j))])
}

/// β from the products with y.
fn solved(inverse: &Mat<f64>, products: &Mat<f64>) -> Vec<f64> {
    let unknowns = inverse.nrows();
    (inverse * products.row(unknowns).subcols(0, unknowns).transpose()).iter().copied().collect()
}

/// Probability of two estimates of the same coefficients so far apart by chance, `plain` of which needs less
/// to be true:
///
/// H = qᵀ (V_plain − V_weighted)⁻¹ q, q their difference, is χ² with as many degrees of freedom as there are
/// coefficients. Where the difference of the covariances is none (the noise is not as was thought), V_plain
/// stands in its place.
///
/// Source: J. A. Hausman, Specification tests in econometrics, Econometrica 46 (1978) 1251–1271.
///
/// Errors: [`Error::Decomposition`] for a covariance that is none.
pub fn agreement_p(plain: (&[f64], &Mat<f64>), weighted: (&[f64], &Mat<f64>)) -> Result<f64, Error> {
    let count = plain.0.len();
    let [alone, less] = [plain.1, weighted.1].map(|of| of.submatrix(0, 0, count, count).to_owned());
    let inverse = Positive::of(&(&alone - less)).or_else(|_| Positive::of(&alone))?.inverse;
    let apart = ColRef::from_slice(plain.0) - ColRef::from_slice(weighted.0);
    let distance = apart.transpose() * inverse * &apart;
    Ok(chi_squared_p(distance.max(0.0), count as f64))
}
