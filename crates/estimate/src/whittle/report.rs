//! What a fit says about the noise.

use faer::Mat;

use super::estimate::Estimate;
use super::likelihood::{EXPONENTS, Model, White};
use crate::Error;
use crate::scoring::{Likelihood, Optimum, inverse, minimise, upper};
use crate::stats::chi_squared_p;

/// Fewest ordinates of a group that is held against the model.
const LEAST_ORDINATES: f64 = 30.0;

/// Noise of a channel: P(f) = A f^-α + 2 σ² Δt (one-sided, unit²/Hz).
#[derive(Clone, Debug)]
pub struct WhittleFit {
    /// A, the density of the flicker noise at 1 Hz (unit²/Hz). Its value is 0 where flicker is not
    /// significant (1 %); then α is held at 1, and the uncertainty is that of a one-sided bound.
    pub amplitude: Estimate,
    /// α. Uncertainty 0 where it is held.
    pub exponent: Estimate,
    /// Whether α was stopped by its limits, 0.2 and 2.5: the model is not that of the noise.
    pub exponent_at_limit: bool,
    /// What is the same in the white noise of all series.
    pub white: White,
    /// σ, rms of the white part of a reading of each series (unit); 0 where it is not significant (1 %).
    pub white_rms: Vec<Estimate>,
    /// The white variances of greatest likelihood, significant or not: σ² (unit²) or the density N
    /// (unit²/Hz), one for all series or one each.
    pub white_variances: Vec<f64>,
    /// Covariance of (ln A, α, white variances); zero for A and α where flicker is not significant.
    pub covariance: Mat<f64>,
    /// Probability that ordinates of the model are as far from it, by the sum of squares over groups of at
    /// least 30 (a shorter series is one group); None without more groups than unknowns.
    pub goodness: Option<f64>,
}

impl WhittleFit {
    /// Density A f^-α of the flicker noise (unit²/Hz).
    pub fn flicker_density(&self, frequency_hz: f64) -> Estimate {
        let x = frequency_hz.ln();
        let shape = (-self.exponent.value * x).exp();
        self.sum([shape, -x * shape], None)
    }

    /// Density A f^-α + 2 σ² Δt of readings `step_s` apart (unit²/Hz), with the white noise of `series`;
    /// white noise of one density is that density at any step.
    pub fn density(&self, series: usize, step_s: f64, frequency_hz: f64) -> Estimate {
        let x = frequency_hz.ln();
        let shape = (-self.exponent.value * x).exp();
        self.sum([shape, -x * shape], Some((series, self.white.density(step_s))))
    }

    /// The value of [`WhittleFit::density`] alone.
    pub fn level(&self, series: usize, step_s: f64, frequency_hz: f64) -> f64 {
        let own = if self.white == White::Each { series } else { 0 };
        let flicker = self.amplitude.value * (-self.exponent.value * frequency_hz.ln()).exp();
        flicker + self.white_variances[own] * self.white.density(step_s)
    }

    /// Variance ∫ A f^-α df of the flicker noise in a band (unit²). NaN unless 0 < low ≤ high.
    pub fn flicker_variance(&self, low_hz: f64, high_hz: f64) -> Estimate {
        self.sum(power_law(self.exponent.value, low_hz, high_hz), None)
    }

    /// A times the first of `flicker` and the white variance of a series times what stands beside it.
    /// `flicker[1]` is the derivative of the first with respect to α.
    fn sum(&self, flicker: [f64; 2], white: Option<(usize, f64)>) -> Estimate {
        let amplitude = self.amplitude.value;
        let mut slope = vec![0.0; self.covariance.nrows()];
        (slope[0], slope[1]) = (amplitude * flicker[0], amplitude * flicker[1]);
        let mut value = amplitude * flicker[0];
        if let Some((series, factor)) = white {
            let own = if self.white == White::Each { series } else { 0 };
            slope[2 + own] = factor;
            value += self.white_variances[own] * factor;
        }
        let row = |i: usize| (0..slope.len()).map(|j| self.covariance[(i, j)] * slope[j]).sum::<f64>();
        let seen: f64 = (0..slope.len()).map(|i| slope[i] * row(i)).sum();
        // Flicker below the bound may be there; with α = 1 by convention.
        let unseen = if amplitude > 0.0 { 0.0 } else { self.amplitude.std * flicker[0] };
        Estimate { value, std: (seen.max(0.0) + unseen * unseen).sqrt() }
    }
}

/// ∫ f^-α df and its derivative with respect to α, −∫ ln f f^-α df: with u = ln f about the middle m of the
/// band, half its width h and z = (1 − α) h, e^((1−α) m) 2 h sinh z/z and −m times that − e^((1−α) m) 2 h² (z
/// cosh z − sinh z)/z².
fn power_law(exponent: f64, low_hz: f64, high_hz: f64) -> [f64; 2] {
    if !(low_hz > 0.0 && low_hz <= high_hz) {
        return [f64::NAN; 2];
    }
    let (low, high) = (low_hz.ln(), high_hz.ln());
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let z = (1.0 - exponent) * half;
    let (even, odd) = if z.abs() < 1e-2 {
        (1.0 + z * z / 6.0 * (1.0 + z * z / 20.0), z / 3.0 * (1.0 + z * z / 10.0))
    } else {
        (z.sinh() / z, (z * z.cosh() - z.sinh()) / (z * z))
    };
    let scale = 2.0 * half * ((1.0 - exponent) * middle).exp();
    [scale * even, -scale * (middle * even + half * odd)]
}

/// What a maximum says.
pub(super) fn report(model: &Model, found: &Optimum) -> Result<WhittleFit, Error> {
    let (data, theta) = (model.data, &found.theta);
    let flicker = theta[0] > 0.0;
    let kept: Vec<usize> = (if flicker { 0 } else { 2 }..theta.len()).collect();
    let mut covariance = inverse(&model.slope(theta).fisher, &kept)?;
    // From the amplitude at the lowest frequency to the logarithm of that at 1 Hz: ln A = ln θ₀ + α ln f₀.
    if flicker {
        (0..theta.len()).for_each(|i| covariance[(0, i)] /= theta[0]);
        (0..theta.len()).for_each(|i| covariance[(i, 0)] /= theta[0]);
    }
    for i in 0..theta.len() {
        covariance[(0, i)] += data.lowest * covariance[(1, i)];
    }
    for i in 0..theta.len() {
        covariance[(i, 0)] += data.lowest * covariance[(i, 1)];
    }
    let amplitude = if flicker {
        let value = theta[0] * (theta[1] * data.lowest).exp();
        Estimate { value, std: value * covariance[(0, 0)].sqrt() }
    } else {
        // Of an exponent of one.
        let best = minimise(model, theta.clone(), &[1])?;
        Estimate::below(upper(model, &best, 0, &[1])? * data.lowest.exp())
    };
    let white_variances: Vec<f64> = theta[2..].to_vec();
    let mut whites = Vec::new();
    for (group, variance) in white_variances.iter().enumerate() {
        let seen = Estimate { value: *variance, std: covariance[(2 + group, 2 + group)].sqrt() };
        whites.push(if flicker { seen.or_below(model, found, 2 + group, &[])? } else { seen });
    }
    let of_series = |series: usize| {
        let variance = whites[model.group(series)];
        // From the unknown to the variance of a reading.
        let factor = model.shape(series) / (2.0 * data.step_s[series]);
        Estimate { value: factor * variance.value, std: factor * variance.std }.root()
    };
    let unknowns = if flicker { theta.len() } else { theta.len() - 2 };
    Ok(WhittleFit {
        amplitude,
        exponent: Estimate { value: theta[1], std: covariance[(1, 1)].sqrt() },
        exponent_at_limit: flicker && [EXPONENTS.0, EXPONENTS.1].contains(&theta[1]),
        white: model.white,
        white_rms: (0..data.series()).map(of_series).collect(),
        white_variances,
        covariance,
        goodness: goodness(model, theta, unknowns),
    })
}

/// Neighbouring ordinates of a series: the mean of I/P, and their number.
struct Group {
    series: usize,
    ratio: f64,
    count: f64,
}

/// Neighbours of one series together as long as `few` says so of the last group and of what comes next.
fn joined(parts: impl Iterator<Item = Group>, few: impl Fn(&Group, &Group) -> bool) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for next in parts {
        match groups.last_mut().filter(|last| last.series == next.series && few(last, &next)) {
            Some(last) => {
                let count = last.count + next.count;
                last.ratio = (last.ratio * last.count + next.ratio * next.count) / count;
                last.count = count;
            }
            None => groups.push(next),
        }
    }
    groups
}

/// The ratio I/P of m ordinates as a standard normal variable: m I/P has the gamma distribution of shape m, and
/// 3 √m ((I/P)^(1/3) − 1 + 1/(9 m)) is normal to a part in a thousand. The probability of a greater Σ of their
/// squares, `unknowns` of them fitted; None with no more groups than that.
///
/// Source: E. B. Wilson and M. M. Hilferty, The distribution of chi-square, Proc. Natl. Acad. Sci. 17 (1931)
/// 684–688.
fn goodness(model: &Model, theta: &[f64], unknowns: usize) -> Option<f64> {
    let ordinates = model.parts(theta).map(|(bin, flicker, white)| Group {
        series: bin.series,
        ratio: bin.density / (flicker + white),
        count: bin.count,
    });
    let groups = joined(ordinates, |last, _| last.count < LEAST_ORDINATES);
    // What is left over at the end of a series goes to the group before.
    let groups = joined(groups.into_iter(), |_, next| next.count < LEAST_ORDINATES);
    let freedom = groups.len().checked_sub(unknowns).filter(|freedom| *freedom > 0)?;
    let normal = |of: &Group| 3.0 * of.count.sqrt() * (of.ratio.cbrt() - 1.0 + 1.0 / (9.0 * of.count));
    Some(chi_squared_p(groups.iter().map(|group| normal(group).powi(2)).sum(), freedom as f64))
}
