//! The noise of the difference d = T − R η of one axis.

use estimate::cosine::{self, Cosine, Errors};
use estimate::periodogram::{Periodogram, periodogram};
use estimate::whittle::{self, WhittleFit};

use crate::Error;
use crate::octaves::Octaves;
use joined::Pair;

/// A form that is so improbable is not that of the noise.
const REJECTED_BELOW: f64 = 1e-3;

/// The noise of a difference, with the density that weighs a regression.
#[derive(Clone)]
pub struct Noise {
    fit: WhittleFit,
    step_s: f64,
    /// Above it nothing is used, Hz.
    highest_hz: f64,
    /// What the octaves have over the form, where they are not of it.
    octaves: Octaves,
}

impl Noise {
    /// A/f^α + white, by maximum likelihood of the ordinates of a difference of the pair, in the band that no
    /// filter touched. Filled rows are quiet: the density is raised by what they lack.
    pub fn of(ordinates: Periodogram, pair: &Pair) -> Result<Self, Error> {
        Self::by(&used(ordinates, pair), pair)
    }

    /// The same with a level of each octave over that form where the ordinates reject it.
    pub fn by_octaves(ordinates: Periodogram, pair: &Pair) -> Result<Self, Error> {
        let used = used(ordinates, pair);
        let noise = Self::by(&used, pair)?;
        if noise.fit.goodness.is_none_or(|p| p >= REJECTED_BELOW) {
            return Ok(noise);
        }
        let octaves = Octaves::of(&used.bins, |f| noise.level(f));
        Ok(Self { octaves, ..noise })
    }

    fn by(used: &Periodogram, pair: &Pair) -> Result<Self, Error> {
        let fit = whittle::fit(std::slice::from_ref(used))?;
        Ok(Self { fit, step_s: pair.step_s, highest_hz: f64::INFINITY, octaves: Octaves::default() })
    }

    /// The same by its form alone.
    pub fn form(self) -> Self {
        Self { octaves: Octaves::default(), ..self }
    }

    /// The same of the periodogram of a difference.
    pub fn seen(difference: &[f64], pair: &Pair) -> Result<Self, Error> {
        Self::of(periodogram(difference, pair.step_s)?, pair)
    }

    /// The form that was fitted.
    pub fn fitted(&self) -> &WhittleFit {
        &self.fit
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
        self.fit.level(0, self.step_s, frequency_hz) * self.octaves.ratio(frequency_hz)
    }

    /// The same for weights: infinite where nothing is to be weighed.
    pub fn density(&self, frequency_hz: f64) -> f64 {
        if frequency_hz > self.highest_hz { f64::INFINITY } else { self.level(frequency_hz) }
    }

    /// Standard uncertainty of that over it.
    pub fn relative_std(&self, frequency_hz: f64) -> f64 {
        cosine::relative_std(&self.fit, self.step_s, frequency_hz)
            .hypot(self.octaves.relative_std(frequency_hz))
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
        let errors = Errors::of(&self.fit, cosine)?;
        Ok(if self.octaves.is_empty() { errors } else { errors.scaled(cosine, |f| self.octaves.ratio(f)) })
    }

    /// Degrees of freedom of the variance of an estimate with these squares of whitened weights, by bins.
    pub fn freedom(&self, cosine: &Cosine, influence: &[f64]) -> f64 {
        cosine.freedom(|f| self.relative_std(f), influence)
    }
}

/// Ordinates of the band that no filter touched, over the share of rows that are whole.
fn used(mut ordinates: Periodogram, pair: &Pair) -> Periodogram {
    let highest = pair.highest_hz.unwrap_or(f64::INFINITY);
    ordinates.bins.retain(|bin| bin.frequency_hz <= highest);
    let share = pair.whole.len() as f64 / pair.samples() as f64;
    ordinates.bins.iter_mut().for_each(|bin| bin.density *= share);
    ordinates
}
