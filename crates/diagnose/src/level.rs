//! How improbable a gain is by chance.

use common::PlainRegression;
use estimate::stats::{chi_squared_p, f_p};

/// Standard deviations of a sum of squares that chance is allowed.
const BEYOND_CHANCE: f64 = 2.0;

/// What is left of a fit, and how well the size of its noise is known.
#[derive(Clone, Copy, Debug)]
pub struct Rest {
    /// Σ of the squared whitened residuals.
    pub sum_of_squares: f64,
    /// Its degrees of freedom.
    pub freedom: f64,
    /// Degrees of freedom with which the noise is known beforehand: infinite where it is declared.
    pub known: f64,
}

impl Rest {
    /// Probability of such a gain of a group of this rank by chance: χ² where the noise is known, F with what
    /// is left and what was known beforehand where it is not.
    pub fn p(&self, gain: f64, rank: usize) -> f64 {
        let rank = rank as f64;
        if rank == 0.0 || !gain.is_finite() || gain <= 0.0 {
            return 1.0;
        }
        if self.known.is_infinite() {
            return chi_squared_p(gain, rank);
        }
        let freedom = self.known + self.freedom - rank;
        if freedom < 1.0 {
            return 1.0;
        }
        let left = (self.known + self.sum_of_squares - gain).max(1e-12 * self.sum_of_squares);
        f_p(gain / rank / (left / freedom), rank, freedom)
    }

    /// What others leave that gain so much with so many unknowns.
    pub fn beside(&self, gain: f64, unknowns: usize) -> Self {
        let freedom = (self.freedom - unknowns as f64).max(1.0);
        Self { sum_of_squares: (self.sum_of_squares - gain).max(0.0), freedom, ..*self }
    }

    /// Probability of such a gain of an event, which is significant against the scatter of its own series.
    pub fn p_of_event(&self, gain: f64, scatter: f64, rank: usize) -> f64 {
        let left = self.sum_of_squares - gain;
        let (gain, left) = (gain / scatter, (left / scatter).max(left.min(self.freedom)));
        Self { sum_of_squares: gain + left, ..*self }.p(gain, rank)
    }

    /// ln of the likelihood ratio of two sums of squares, the noise's size averaged out where it is not known.
    pub fn log_likelihood(&self, whole: f64, left: f64) -> f64 {
        if self.known.is_infinite() {
            return 0.5 * (whole - left);
        }
        -0.5 * (self.known + self.freedom) * ((self.known + left) / (self.known + whole)).ln()
    }

    /// By how much a sum of squares is beyond what the noise makes of it, its own scatter and what is known
    /// of its size allowed for. None where the size of the noise is what the residual shows.
    pub fn excess(&self, left: f64) -> f64 {
        if self.known == 0.0 {
            return 0.0;
        }
        let spread = self.freedom * (2.0 / self.freedom + 2.0 / self.known).sqrt();
        (left - self.freedom - BEYOND_CHANCE * spread).max(0.0)
    }

    /// Whether more is left than noise leaves, and by a share of the rms that matters.
    pub fn is_beyond(&self) -> bool {
        self.excess(self.sum_of_squares) > 0.0
            && (self.sum_of_squares / self.freedom).sqrt() > PlainRegression::WORSE
    }

    /// Whether the scatter is beyond the declaration by more than chance, its own uncertainty aside.
    pub fn is_larger(&self, level: f64) -> bool {
        self.known > 0.0 && chi_squared_p(self.sum_of_squares, self.freedom) < level
    }

    /// Variance of the errors in units of the noise that is allowed for.
    pub fn scale(&self) -> f64 {
        if self.known.is_infinite() {
            1.0
        } else {
            (self.known + self.sum_of_squares) / (self.known + self.freedom).max(1.0)
        }
    }

    /// Probability of a larger sum of squares under the noise as declared; None where it was estimated.
    pub fn omnibus(&self) -> Option<f64> {
        match self.known {
            known if known.is_infinite() => Some(chi_squared_p(self.sum_of_squares, self.freedom)),
            known if known > 0.0 => Some(f_p(self.sum_of_squares / self.freedom, self.freedom, known)),
            _ => None,
        }
    }
}

/// 1 − (1 − p)^m.
pub fn at_least_one(p: f64, count: f64) -> f64 {
    if p >= 1.0 { 1.0 } else { -(count * (-p).ln_1p()).exp_m1() }
}

/// As how many independent looks a search over all frequencies of a band counts, where the strongest gains so
/// much: the expected upcrossings of χ² along the frequency, per probability of one look. `x` is what the
/// waves run along.
///
/// √(4π var x) Δν √(gain/2). Source: Davies 1987, Hypothesis testing when a nuisance parameter is present
/// only under the alternative, Biometrika 74, 33; Baluev 2008, Assessing the statistical significance of
/// periodogram peaks, MNRAS 385, 1279, eq. 8.
pub fn looks_along(x: &[f64], band: f64, gain: f64) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    let variance = x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / x.len() as f64;
    ((4.0 * std::f64::consts::PI * variance).sqrt() * band * (0.5 * gain).sqrt()).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 4 000 readings a step makes nearly all that is left, and most of the scatter of its series with it; one
    /// that is a hundredth of a series that scatters as much is nothing.
    #[test]
    fn an_event_is_not_held_against_the_scatter_that_it_makes() {
        for known in [50.0, f64::INFINITY] {
            let rest = |sum_of_squares| Rest { sum_of_squares, freedom: 4000.0, known };
            assert!(rest(1.2e6).p_of_event(1.196e6, 580.0, 1) < 1e-12);
            assert!(rest(1.2e6).p_of_event(300.0, 580.0, 1) > 0.1);
            let [event, plain] = [rest(4100.0).p_of_event(100.0, 1.0, 1), rest(4100.0).p(100.0, 1)];
            assert!((event / plain - 1.0).abs() < 1e-9);
        }
    }
}
