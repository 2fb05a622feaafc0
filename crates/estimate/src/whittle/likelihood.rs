//! The Whittle likelihood of periodograms under a power law and white noise.

use std::f64::consts::PI;

use faer::Mat;

use super::White;
use crate::Error;
use crate::periodogram::Periodogram;
use crate::scoring::{Likelihood, Slope};

/// Least and largest exponent α.
pub(crate) const EXPONENTS: (f64, f64) = (0.2, 2.5);
/// Longest step in the exponent.
pub(crate) const LONGEST: f64 = 0.5;

/// The bins of all series.
pub(super) struct Data {
    pub bins: Vec<Binned>,
    pub step_s: Vec<f64>,
    /// ln of the lowest frequency (Hz).
    pub lowest: f64,
}

/// A bin of one of the series.
pub(super) struct Binned {
    /// ln of the frequency over the lowest one.
    pub x: f64,
    /// What its flicker lacks is this share times α (2 − α); see [`Periodogram::mirrored`].
    pub lacking: f64,
    pub density: f64,
    pub ln_density: f64,
    pub count: f64,
    pub series: usize,
}

impl Binned {
    /// The flicker of amplitude one and its first two derivatives with respect to α: e^(−αx) (1 − α (2 − α) u).
    fn flicker(&self, exponent: f64) -> [f64; 3] {
        let (x, u, power) = (self.x, self.lacking, (-exponent * self.x).exp());
        let (seen, slope) = (1.0 - exponent * (2.0 - exponent) * u, 2.0 * (1.0 - exponent) * u);
        [power * seen, -power * (x * seen + slope), power * (x * x * seen + 2.0 * x * slope + 2.0 * u)]
    }
}

impl Data {
    pub fn of(series: &[Periodogram]) -> Result<Self, Error> {
        let all = || series.iter().flat_map(|s| &s.bins);
        if all().any(|bin| !(bin.density.is_finite() && bin.frequency_hz > 0.0 && bin.count > 0.0)) {
            return Err(Error::Series("with ordinates that are not finite"));
        }
        if series.iter().any(|s| s.bins.iter().all(|bin| bin.density <= 0.0)) {
            return Err(Error::Series("that does not vary"));
        }
        let (count, unknowns) = (all().map(|bin| bin.count).sum::<f64>() as usize, 2 + series.len());
        if count <= unknowns || series.is_empty() {
            return Err(Error::TooFew { found: count, unknowns: unknowns + 1 });
        }
        let lowest = all().map(|bin| bin.frequency_hz).fold(f64::INFINITY, f64::min).ln();
        let bins = series.iter().enumerate().flat_map(|(number, s)| {
            s.bins.iter().map(move |bin| Binned {
                x: bin.frequency_hz.ln() - lowest,
                // k = 2 f T.
                lacking: if s.mirrored { 1.0 / (PI * PI * bin.frequency_hz * s.length_s) } else { 0.0 },
                density: bin.density,
                ln_density: bin.density.max(f64::MIN_POSITIVE).ln(),
                count: bin.count,
                series: number,
            })
        });
        Ok(Data { bins: bins.collect(), step_s: series.iter().map(|s| s.step_s).collect(), lowest })
    }

    pub fn series(&self) -> usize {
        self.step_s.len()
    }

    /// Σ count (1 + ln I): with the cost of a state, minus its log likelihood.
    pub fn saturated(&self) -> f64 {
        self.bins.iter().map(|bin| bin.count * (1.0 + bin.ln_density)).sum()
    }
}

/// P = θ₀ (f/f₀)^−θ₁ (1 − θ₁ (2 − θ₁) u) + c θ_(2+g), f₀ the lowest frequency, u what a mirrored series lacks; g the group and c the shape of the white
/// part of a series.
///
/// The amplitude is held at the lowest frequency, where flicker is seen best. A θ₀ or white θ of zero: that part is absent.
pub(super) struct Model<'a> {
    pub data: &'a Data,
    pub white: White,
}

impl Model<'_> {
    /// Number of white unknowns.
    pub fn groups(&self) -> usize {
        if self.white == White::Each { self.data.series() } else { 1 }
    }

    /// The white unknown of a series.
    pub fn group(&self, series: usize) -> usize {
        if self.white == White::Each { series } else { 0 }
    }

    /// The density of the white part of a series for a white unknown of one.
    pub fn shape(&self, series: usize) -> f64 {
        self.white.density(self.data.step_s[series])
    }

    /// The mean over the ordinates of each group.
    fn pooled(&self, of: impl Fn(&Binned) -> f64) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.groups()];
        for bin in &self.data.bins {
            let sum = &mut sums[self.group(bin.series)];
            *sum = (sum.0 + bin.count * of(bin), sum.1 + bin.count);
        }
        sums.into_iter().map(|(sum, count)| sum / count).collect()
    }

    /// The unknowns of another form of white noise as those of each series.
    pub fn spread(&self, other: &Model, theta: &[f64]) -> Vec<f64> {
        let white = |s: usize| theta[2 + other.group(s)] * other.shape(s) / self.shape(s);
        theta[..2].iter().copied().chain((0..self.data.series()).map(white)).collect()
    }

    /// The white noise of greatest likelihood without flicker: the mean ordinate of each group.
    pub fn white_only(&self) -> Vec<f64> {
        let whites = self.pooled(|bin| bin.density / self.shape(bin.series));
        [0.0, 1.0].into_iter().chain(whites).collect()
    }

    /// Flicker and white part of the density of a bin.
    pub fn parts(&self, theta: &[f64], bin: &Binned) -> (f64, f64) {
        let white = theta[2 + self.group(bin.series)] * self.shape(bin.series);
        (theta[0] * bin.flicker(theta[1])[0], white)
    }
}

impl Likelihood for Model<'_> {
    /// Σ count (I/P − 1 − ln(I/P)), half the deviance.
    fn cost(&self, theta: &[f64]) -> f64 {
        let term = |bin: &Binned| {
            let (flicker, white) = self.parts(theta, bin);
            let density = flicker + white;
            bin.count * (bin.density / density - 1.0 + density.ln() - bin.ln_density)
        };
        self.data.bins.iter().map(term).sum()
    }

    /// Cost and derivatives. With s = ∂P/∂θ / P and q = ∂²P/∂θ² / P the gradient of an ordinate is (1 − I/P) s, its second
    /// derivative (2 I/P − 1) s sᵀ + (1 − I/P) q, and the expectation of that s sᵀ.
    fn slope(&self, theta: &[f64]) -> Slope {
        let unknowns = theta.len();
        let (mut cost, mut gradient) = (0.0, vec![0.0; unknowns]);
        let (mut hessian, mut fisher) = (Mat::zeros(unknowns, unknowns), Mat::zeros(unknowns, unknowns));
        for bin in &self.data.bins {
            let ([shape, first, second], white_shape) = (bin.flicker(theta[1]), self.shape(bin.series));
            let own = 2 + self.group(bin.series);
            let density = theta[0] * shape + theta[own] * white_shape;
            let ratio = bin.density / density;
            cost += bin.count * (ratio - 1.0 + density.ln() - bin.ln_density);
            let s = [(0, shape / density), (1, theta[0] * first / density), (own, white_shape / density)];
            for (i, slope) in s {
                gradient[i] += bin.count * (1.0 - ratio) * slope;
                for (j, other) in s {
                    fisher[(i, j)] += bin.count * slope * other;
                    hessian[(i, j)] += bin.count * (2.0 * ratio - 1.0) * slope * other;
                }
            }
            let bent = bin.count * (1.0 - ratio) / density;
            hessian[(0, 1)] += bent * first;
            hessian[(1, 0)] += bent * first;
            hessian[(1, 1)] += bent * theta[0] * second;
        }
        Slope { cost, gradient, hessian, fisher }
    }

    fn limits(&self, theta: &[f64], unknown: usize) -> (f64, f64) {
        match unknown {
            1 => ((EXPONENTS.0 - theta[1]).max(-LONGEST), (EXPONENTS.1 - theta[1]).min(LONGEST)),
            _ => (-theta[unknown], f64::INFINITY),
        }
    }
}
