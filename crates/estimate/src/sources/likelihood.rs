//! The likelihood of spectral matrices under flicker and white noise of each source.

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, Side};

use crate::cross_spectrum::CrossSpectra;
use crate::scoring::{Likelihood, Slope};
use crate::whittle::{EXPONENTS, LONGEST};

/// Multiplicative steps of a start.
const START_STEPS: usize = 30;

/// Series that are sums of independent sources.
pub struct Mixture<'a> {
    /// Their spectral matrices, of the whole series without a taper.
    pub spectra: &'a CrossSpectra,
    /// From one sample to the next, s.
    pub step_s: f64,
    /// What each source gives to each series.
    pub columns: Vec<Vec<f64>>,
    /// What is in them besides and is known.
    pub known: Vec<KnownNoise>,
}

/// Sources of known noise, up to one factor with an uncertainty.
pub struct KnownNoise {
    /// What each gives to each series.
    pub columns: Vec<Vec<f64>>,
    /// Density of each at the frequencies of the spectra (unit²/Hz).
    pub densities: Vec<Vec<f64>>,
    /// Relative standard uncertainty of the densities, the same factor in all.
    pub relative_std: f64,
}

/// θ: for each source the flicker at the lowest frequency f₀, its exponent, and the white variance of a
/// reading; then the factor of what is known, of each group of it.
pub(super) struct Model<'a> {
    mixture: &'a Mixture<'a>,
    /// Real parts of the spectral matrices: those of P are real.
    real: Vec<Mat<f64>>,
    /// Columns of all sources, those known last.
    columns: Mat<f64>,
    /// Group and place in it of each column that is known.
    known: Vec<(usize, usize)>,
    /// ln of the lowest frequency (Hz).
    pub lowest: f64,
    /// ln f/f₀ of each matrix.
    x: Vec<f64>,
    /// Unknowns that are held.
    pub tied: Vec<usize>,
}

impl<'a> Model<'a> {
    pub fn of(mixture: &'a Mixture<'a>) -> Self {
        let real =
            |matrix: &Mat<faer::c64>| Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)].re);
        let all: Vec<&Vec<f64>> =
            mixture.columns.iter().chain(mixture.known.iter().flat_map(|group| &group.columns)).collect();
        let groups = mixture.known.iter().enumerate();
        let lowest = mixture.spectra.frequency_hz.first().copied().unwrap_or(1.0).ln();
        let first = 3 * mixture.columns.len();
        Self {
            real: mixture.spectra.matrices.iter().map(real).collect(),
            columns: Mat::from_fn(all.first().map_or(0, |c| c.len()), all.len(), |i, a| all[a][i]),
            known: groups
                .clone()
                .flat_map(|(group, known)| (0..known.columns.len()).map(move |place| (group, place)))
                .collect(),
            lowest,
            x: mixture.spectra.frequency_hz.iter().map(|frequency| frequency.ln() - lowest).collect(),
            tied: groups
                .filter(|(_, known)| known.relative_std <= 0.0)
                .map(|(group, _)| first + group)
                .collect(),
            mixture,
        }
    }

    fn sources(&self) -> usize {
        self.mixture.columns.len()
    }

    /// Shapes of flicker and white noise of a source.
    fn shapes(&self, theta: &[f64], source: usize, bin: usize) -> [f64; 2] {
        [(-theta[3 * source + 1] * self.x[bin]).exp(), 2.0 * self.mixture.step_s]
    }

    /// P of one column, and its slopes over the unknowns.
    fn own(&self, theta: &[f64], column: usize, bin: usize) -> (f64, [(usize, f64); 3]) {
        let first = 3 * column;
        if column < self.sources() {
            let [flicker, white] = self.shapes(theta, column, bin);
            let bent = -self.x[bin] * theta[first] * flicker;
            let slopes = [(first, flicker), (first + 1, bent), (first + 2, white)];
            return (theta[first] * flicker + theta[first + 2] * white, slopes);
        }
        let (group, place) = self.known[column - self.sources()];
        let factor = 3 * self.sources() + group;
        let density = self.mixture.known[group].densities[place][bin];
        (theta[factor] * density, [(factor, density), (factor, 0.0), (factor, 0.0)])
    }

    /// P of the series.
    pub fn density(&self, theta: &[f64], bin: usize) -> Mat<f64> {
        let size = self.columns.nrows();
        let mut density = Mat::zeros(size, size);
        for a in 0..self.columns.ncols() {
            let (own, _) = self.own(theta, a, bin);
            for i in 0..size {
                (0..size).for_each(|j| density[(i, j)] += own * self.columns[(i, a)] * self.columns[(j, a)]);
            }
        }
        density
    }

    /// For each factor that may move half of ((κ − 1)/u)², with first and second derivative.
    fn declared(&self, theta: &[f64]) -> impl Iterator<Item = (usize, [f64; 3])> {
        let first = 3 * self.sources();
        let factors = self.mixture.known.iter().enumerate().filter(|(_, known)| known.relative_std > 0.0);
        factors.map(move |(group, known)| {
            let weight = known.relative_std.powi(-2);
            let off = theta[first + group] - 1.0;
            (first + group, [0.5 * weight * off * off, weight * off, weight])
        })
    }

    /// n, k_aᵀP⁻¹ k_b, k_aᵀP⁻¹ Ŝ P⁻¹ k_b and the cost of a matrix; none where P is not positive definite.
    fn products(&self, theta: &[f64], bin: usize) -> Option<(f64, Mat<f64>, Mat<f64>, f64)> {
        let count = 0.5 * self.mixture.spectra.freedom[bin];
        let factor = self.density(theta, bin).as_ref().llt(Side::Lower).ok()?;
        let root = factor.L();
        let log = (0..root.nrows()).map(|i| 2.0 * root[(i, i)].ln()).sum::<f64>();
        let inverse = factor.inverse();
        let half = &inverse * &self.columns;
        let model = self.columns.transpose() * &half;
        let seen = half.transpose() * &self.real[bin] * &half;
        let size = root.nrows();
        let fit: f64 = (0..size)
            .flat_map(|i| (0..size).map(move |j| (i, j)))
            .map(|at| inverse[at] * self.real[bin][at])
            .sum();
        let cost = count * (log + fit);
        cost.is_finite().then_some((count, model, seen, cost))
    }

    /// A start: half the mean ordinate each for flicker and white noise, then multiplicative steps.
    ///
    /// Source: C. Févotte and J. Idier, Neural Computation 23 (2011) 2421–2456, β = 0.
    pub fn start(&self, exponent: f64) -> Vec<f64> {
        let bins = self.real.len();
        let sources = self.sources();
        let mut theta: Vec<f64> = (0..sources).flat_map(|_| [0.0, exponent, 0.0]).collect();
        theta.resize(3 * sources + self.mixture.known.len(), 1.0);
        let (mut ordinates, mut flicker, mut white) = (0.0, 0.0, 0.0);
        for bin in 0..bins {
            let size = self.real[bin].nrows();
            let count = 0.5 * self.mixture.spectra.freedom[bin];
            let power = (0..size).map(|i| self.real[bin][(i, i)]).sum::<f64>() / size as f64;
            let [shape, level] = self.shapes(&theta, 0, bin);
            ordinates += count;
            flicker += count * power / shape;
            white += count * power / level;
        }
        for source in 0..sources {
            (theta[3 * source], theta[3 * source + 2]) = (0.5 * flicker / ordinates, 0.5 * white / ordinates);
        }
        for _ in 0..START_STEPS {
            let mut sums = vec![[0.0; 2]; theta.len()];
            for bin in 0..bins {
                let Some((count, model, seen, _)) = self.products(&theta, bin) else { continue };
                for source in 0..sources {
                    let shapes = self.shapes(&theta, source, bin);
                    for (unknown, shape) in [(3 * source, shapes[0]), (3 * source + 2, shapes[1])] {
                        sums[unknown][0] += count * shape * seen[(source, source)];
                        sums[unknown][1] += count * shape * model[(source, source)];
                    }
                }
            }
            for (theta, [up, down]) in theta.iter_mut().zip(sums).filter(|(_, [_, down])| *down > 0.0) {
                *theta *= (up / down).sqrt();
            }
        }
        theta
    }
}

impl Likelihood for Model<'_> {
    fn cost(&self, theta: &[f64]) -> f64 {
        (0..self.real.len())
            .map(|bin| self.products(theta, bin).map_or(f64::INFINITY, |(_, _, _, cost)| cost))
            .chain(self.declared(theta).map(|(_, [cost, ..])| cost))
            .sum()
    }

    /// ∂cost/∂p_a = n (k_aᵀP⁻¹k_a − k_aᵀP⁻¹ŜP⁻¹k_a); the Fisher information of p_a, p_b is n (k_aᵀP⁻¹k_b)².
    fn slope(&self, theta: &[f64]) -> Slope {
        let unknowns = theta.len();
        let (mut cost, mut gradient) = (0.0, vec![0.0; unknowns]);
        let (mut fisher, mut hessian) = (Mat::zeros(unknowns, unknowns), Mat::zeros(unknowns, unknowns));
        for bin in 0..self.real.len() {
            let Some((count, model, seen, of_bin)) = self.products(theta, bin) else {
                cost = f64::INFINITY;
                continue;
            };
            cost += of_bin;
            let x = self.x[bin];
            let slopes: Vec<[(usize, f64); 3]> =
                (0..self.columns.ncols()).map(|column| self.own(theta, column, bin).1).collect();
            for (a, own) in slopes.iter().enumerate() {
                let down = count * (model[(a, a)] - seen[(a, a)]);
                for (i, slope) in own {
                    gradient[*i] += down * slope;
                }
                if a < self.sources() {
                    let bent = down * x * own[0].1;
                    hessian[(3 * a, 3 * a + 1)] -= bent;
                    hessian[(3 * a + 1, 3 * a)] -= bent;
                    hessian[(3 * a + 1, 3 * a + 1)] += bent * x * theta[3 * a];
                }
                for (b, other) in slopes.iter().enumerate() {
                    let expected = count * model[(a, b)] * model[(a, b)];
                    let found = count * model[(a, b)] * (2.0 * seen[(a, b)] - model[(a, b)]);
                    for (i, slope) in own {
                        for (j, other) in other {
                            fisher[(*i, *j)] += expected * slope * other;
                            hessian[(*i, *j)] += found * slope * other;
                        }
                    }
                }
            }
        }
        for (unknown, [of_declared, down, weight]) in self.declared(theta) {
            cost += of_declared;
            gradient[unknown] += down;
            fisher[(unknown, unknown)] += weight;
            hessian[(unknown, unknown)] += weight;
        }
        Slope { cost, gradient, hessian, fisher }
    }

    fn limits(&self, theta: &[f64], unknown: usize) -> (f64, f64) {
        if unknown < 3 * self.sources() && unknown % 3 == 1 {
            let alpha = theta[unknown];
            return ((EXPONENTS.0 - alpha).max(-LONGEST), (EXPONENTS.1 - alpha).min(LONGEST));
        }
        (-theta[unknown], f64::INFINITY)
    }
}
