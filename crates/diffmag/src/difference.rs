//! The difference d = T − R η of one axis: its noise.

use common::{AllanDeviation, DifferenceAxis, Quantity};
use estimate::cosine::{self, Cosine, Errors};
use estimate::periodogram::{Periodogram, periodogram};
use estimate::whittle::{self, Estimate, WhittleFit};
use estimate::{allan, stats};

use crate::Error;
use crate::series::Pair;

/// The noise of a difference, with the density that weighs a regression.
#[derive(Clone)]
pub struct Noise {
    fit: WhittleFit,
    step_s: f64,
    /// Above it nothing is used, Hz.
    highest_hz: f64,
}

impl Noise {
    /// A/f^α + white, by maximum likelihood of the ordinates of a difference of the pair, in the band that no filter touched.
    /// Filled rows are quiet: the density is raised by what they lack.
    pub fn of(mut ordinates: Periodogram, pair: &Pair) -> Result<Self, Error> {
        let highest = pair.highest_hz.unwrap_or(f64::INFINITY);
        ordinates.bins.retain(|bin| bin.frequency_hz <= highest);
        let share = pair.whole.len() as f64 / pair.samples() as f64;
        ordinates.bins.iter_mut().for_each(|bin| bin.density *= share);
        Ok(Self { fit: whittle::fit(&[ordinates])?, step_s: pair.step_s, highest_hz: f64::INFINITY })
    }

    /// The same of the periodogram of a difference.
    pub fn seen(difference: &[f64], pair: &Pair) -> Result<Self, Error> {
        Self::of(periodogram(difference, pair.step_s)?, pair)
    }

    /// The same for weights that leave out all above a frequency.
    pub fn up_to(self, highest_hz: f64) -> Self {
        Self { highest_hz, ..self }
    }

    /// Above this nothing is to be weighed, Hz.
    pub fn highest_hz(&self) -> f64 {
        self.highest_hz
    }

    /// Its one-sided density, nT²/Hz.
    pub fn level(&self, frequency_hz: f64) -> f64 {
        self.fit.level(0, self.step_s, frequency_hz)
    }

    /// The same for weights: infinite where nothing is to be weighed.
    pub fn density(&self, frequency_hz: f64) -> f64 {
        if frequency_hz > self.highest_hz { f64::INFINITY } else { self.level(frequency_hz) }
    }

    /// Standard uncertainty of that over it.
    pub fn relative_std(&self, frequency_hz: f64) -> f64 {
        cosine::relative_std(&self.fit, self.step_s, frequency_hz)
    }

    /// A (nT²/Hz at 1 Hz) and α.
    pub fn power_law(&self) -> (f64, f64) {
        (self.fit.amplitude.value, self.fit.exponent.value)
    }

    /// Variance of the white noise of one reading, nT².
    pub fn white_variance(&self) -> f64 {
        self.fit.white_variances[0]
    }

    /// As errors of a regression.
    pub fn errors(&self, cosine: &Cosine) -> Result<Errors, Error> {
        Ok(Errors::of(&self.fit, cosine)?)
    }

    /// Degrees of freedom of the variance of an estimate with these whitened weights.
    pub fn freedom(&self, cosine: &Cosine, weights: &[f64]) -> f64 {
        cosine.freedom(&self.fit, weights)
    }
}

/// What is said of one axis; `source` is the difference of the source's fit, with its drift in it.
pub fn describe(difference: &[f64], source: &[f64], noise: &Noise) -> Result<DifferenceAxis, Error> {
    let freedom = source.len() as f64 - 4.0;
    let squares: f64 = source.iter().map(|d| d * d).sum();
    let bound = |p: f64| (squares / stats::chi_squared_quantile(p, freedom)).sqrt();
    let quantity = |estimate: Estimate| Quantity::new(estimate.value, estimate.std);
    let fit = &noise.fit;
    let mut columns = AllanDeviation::default();
    for point in allan::of_noise(difference, noise.step_s, fit)? {
        columns.push(0, point.averaging_s, point.deviation, point.band(0.95));
    }
    Ok(DifferenceAxis {
        rms_nt: (squares / freedom).sqrt(),
        rms_interval_independent_nt: [bound(0.975), bound(0.025)],
        flicker_nt2_per_hz_at_1hz: quantity(fit.amplitude),
        flicker_exponent: quantity(fit.exponent),
        white_rms_nt: quantity(fit.white_rms[0]),
        density_at_1hz_nt_per_sqrt_hz: quantity(fit.flicker_density(1.0).root()),
        goodness_p: fit.goodness.unwrap_or(1.0),
        allan: columns,
        ..DifferenceAxis::default()
    })
}
