//! Noise of independent sources, from the spectral matrices of series that mix them.

use faer::{Mat, c64};

use crate::Error;
use crate::positive::cholesky;
use crate::scoring::{Likelihood, Optimum, fall_without, inverse, minimise, upper};
use crate::stats::chi_squared_p;
use crate::whittle::{Estimate, FLICKER};

mod likelihood;

pub use likelihood::{KnownNoise, Mixture};

use likelihood::Model;

/// Exponent of flicker that is not significant.
const HELD: f64 = 1.0;
/// Groups of ordinates that are held against the model have at least so many for each series.
const GROUP: f64 = 20.0;

/// Noise of one source: P(f) = A f^-α + 2 σ² Δt.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    /// A, density of the flicker noise at 1 Hz (unit²/Hz); 0 where it is not significant (1 %).
    pub amplitude: Estimate,
    /// α; held at 1, uncertainty 0, where flicker is not significant.
    pub exponent: Estimate,
    /// σ, rms of the white part of a reading (unit); 0 where it is not significant (1 %).
    pub white_rms: Estimate,
    /// A, α and σ² of greatest likelihood, significant or not.
    model: [f64; 3],
    step_s: f64,
}

impl Source {
    /// P, of greatest likelihood (unit²/Hz).
    pub fn density(&self, frequency_hz: f64) -> f64 {
        let [amplitude, exponent, variance] = self.model;
        amplitude * frequency_hz.powf(-exponent) + 2.0 * variance * self.step_s
    }
}

/// The noise of all sources.
#[derive(Clone, Debug)]
pub struct Sources {
    /// One for each column.
    pub sources: Vec<Source>,
    /// Probability of matrices as far from the model; small where sources are dependent or of another form.
    pub goodness: f64,
}

/// Finds A, α and σ of every source by maximum likelihood on the spectral matrices Ŝ,
///
/// −ln L = Σ n (ln det P(f) + tr P(f)⁻¹ Ŝ(f)), P(f) = κ P_known(f) + Σ_a k_a k_aᵀ (A_a f^-α_a + 2 σ_a² Δt),
///
/// n ordinates to each, κ unknown beside its declaration of 1 ± its uncertainty, k_a the columns: complex
/// Wishart matrices, whose likelihood allows no negative noise. With three instruments in one field, and the
/// differences from one of them as series, it is the three-cornered hat. Of sources whose flicker is not
/// significant the exponent is held at 1, while their A, which may be anything not negative, still counts in
/// the uncertainties of the others. Uncertainties are those of the Fisher information.
///
/// Sources: J. E. Gray and D. W. Allan, A method for estimating the frequency stability of an individual
/// oscillator, Proc. 28th Freq. Control Symp. (1974) 243–246; N. R. Goodman, Statistical analysis based on a
/// certain multivariate complex Gaussian distribution, Ann. Math. Stat. 34 (1963) 152–177.
///
/// Errors: [`Error::TooFew`] for fewer ordinates than unknowns, [`Error::NotConverged`] without a maximum,
/// [`Error::Decomposition`] for matrices that are not positive definite.
pub fn fit(mixture: &Mixture<'_>) -> Result<Sources, Error> {
    let count = mixture.columns.len();
    let ordinates = 0.5 * mixture.spectra.freedom.iter().sum::<f64>();
    if ordinates < 3.0 * count as f64 {
        return Err(Error::TooFew { found: ordinates as usize, unknowns: 3 * count });
    }
    let mut model = Model::of(mixture);
    let exponents = (0..count).map(|source| 3 * source + 1);
    let start: Vec<usize> = model.tied.iter().copied().chain(exponents.clone()).collect();
    let straight = minimise(&model, model.start(HELD), &start)?;
    let full = minimise(&model, straight.theta, &model.tied)?;
    let mut theta = full.theta.clone();
    let mut tied = model.tied.clone();
    for exponent in exponents {
        let held: Vec<usize> = model.tied.iter().copied().chain([exponent]).collect();
        if fall_without(&model, &full, exponent - 1, &held)? < FLICKER {
            theta[exponent] = HELD;
            tied.push(exponent);
        }
    }
    model.tied = tied;
    let found = minimise(&model, theta, &model.tied)?;
    report(mixture, &model, &found)
}

fn report(mixture: &Mixture<'_>, model: &Model<'_>, found: &Optimum) -> Result<Sources, Error> {
    let theta = &found.theta;
    let free: Vec<usize> = (0..theta.len()).filter(|unknown| !model.tied.contains(unknown)).collect();
    let covariance = inverse(&model.slope(theta).fisher, &free)?;
    let std = |unknown: usize| covariance[(unknown, unknown)].max(0.0).sqrt();
    let mut sources = Vec::new();
    for source in 0..mixture.columns.len() {
        let [a, alpha, white] = [3 * source, 3 * source + 1, 3 * source + 2];
        // From the amplitude at the lowest frequency to that at 1 Hz: ln A = ln θ + α ln f₀.
        let factor = (theta[alpha] * model.lowest).exp();
        let flicker = !model.tied.contains(&alpha);
        let amplitude = if flicker {
            let variance = covariance[(a, a)] / theta[a].powi(2)
                + 2.0 * model.lowest * covariance[(a, alpha)] / theta[a]
                + model.lowest.powi(2) * covariance[(alpha, alpha)];
            let value = factor * theta[a];
            Estimate { value, std: value * variance.max(0.0).sqrt() }
        } else {
            Estimate::below(factor * upper(model, found, a, &model.tied)?)
        };
        let variance = Estimate { value: theta[white], std: std(white) };
        let variance = variance.or_below(model, found, white, &model.tied)?;
        sources.push(Source {
            amplitude,
            exponent: Estimate { value: theta[alpha], std: if flicker { std(alpha) } else { 0.0 } },
            white_rms: variance.root(),
            model: [factor * theta[a], theta[alpha], theta[white]],
            step_s: mixture.step_s,
        });
    }
    let goodness = goodness(mixture, model, theta)?;
    Ok(Sources { sources, goodness })
}

/// With X = L⁻¹ Ŝ L⁻ᵀ*, P = L Lᵀ, of n ordinates and m series, n tr (X − 1)² is about χ²(m²).
fn goodness(mixture: &Mixture<'_>, model: &Model<'_>, theta: &[f64]) -> Result<f64, Error> {
    let spectra = mixture.spectra;
    let size = spectra.matrices.first().map_or(0, Mat::nrows);
    let nothing = || (Mat::<c64>::zeros(size, size), 0.0);
    let (mut sum, mut freedom) = (0.0, -(theta.len() as f64 - model.tied.len() as f64));
    let mut group = nothing();
    for (bin, matrix) in spectra.matrices.iter().enumerate() {
        let density = model.density(theta, bin);
        let factor = cholesky(density.as_ref())?;
        let root = Mat::from_fn(size, size, |i, j| c64::new(factor.L()[(i, j)], 0.0));
        let mut half = matrix.clone();
        root.solve_lower_triangular_in_place(half.as_mut());
        let mut whole = half.adjoint().to_owned();
        root.solve_lower_triangular_in_place(whole.as_mut());
        let count = 0.5 * spectra.freedom[bin];
        group.0 += Mat::from_fn(size, size, |i, j| whole[(i, j)] * count);
        group.1 += count;
        if group.1 >= GROUP * size as f64 || bin + 1 == spectra.matrices.len() {
            let one = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
            let square = |(i, j): (usize, usize)| (group.0[(i, j)] / group.1 - one(i, j)).norm_sqr();
            let all = (0..size).flat_map(|i| (0..size).map(move |j| (i, j)));
            sum += group.1 * all.map(square).sum::<f64>();
            freedom += (size * size) as f64;
            group = nothing();
        }
    }
    Ok(if freedom > 0.0 { chi_squared_p(sum, freedom) } else { 1.0 })
}
