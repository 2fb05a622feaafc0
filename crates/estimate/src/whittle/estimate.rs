//! Values with their standard uncertainties.

use crate::Error;
use crate::scoring::{Likelihood, Optimum, fall_without, upper};
use crate::stats::coverage_factor;

/// Twice the gain in log likelihood that white noise has to bring: 1 % of half a χ²(1).
const WHITE: f64 = 5.412;
/// The standard normal distribution is below this with a probability of 95 %.
const ONE_SIDED_95: f64 = 1.644_854;

/// A value with its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value. Of what cannot be negative, 0: none was seen.
    pub value: f64,
    /// Its standard uncertainty; beside a value of 0, the one-sided 95 % bound over 1.645.
    pub std: f64,
}

impl Estimate {
    /// None was seen, below a one-sided 95 % bound.
    pub(crate) fn below(bound: f64) -> Self {
        Estimate { value: 0.0, std: bound / ONE_SIDED_95 }
    }

    /// A white variance θ_i at a maximum, with `held` held, where it is significant (1 %); else its bound.
    pub(crate) fn or_below(
        self,
        likelihood: &impl Likelihood,
        found: &Optimum,
        i: usize,
        held: &[usize],
    ) -> Result<Self, Error> {
        let seen = fall_without(likelihood, found, i, held)? > WHITE;
        if seen { Ok(self) } else { Ok(Self::below(upper(likelihood, found, i, held)?)) }
    }

    /// The square root: √v with the uncertainty u/(2 √v), or the root of the bound.
    pub fn root(&self) -> Self {
        let value = self.value.sqrt();
        if self.value > 0.0 {
            Estimate { value, std: 0.5 * self.std / value }
        } else {
            Self::below((ONE_SIDED_95 * self.std).sqrt())
        }
    }

    /// The one-sided 95 % bound where none was seen.
    pub fn bound(&self) -> Option<f64> {
        (self.value == 0.0).then_some(ONE_SIDED_95 * self.std)
    }

    /// The interval that holds the true value with `probability` on a logarithmic scale, v e^(± z u/v): for
    /// an amplitude, an rms or a density. For a value of 0 from 0 to the one-sided bound.
    pub fn log_interval(&self, probability: f64) -> (f64, f64) {
        if self.value <= 0.0 {
            return (0.0, coverage_factor(2.0 * probability - 1.0, f64::INFINITY) * self.std);
        }
        let factor = (coverage_factor(probability, f64::INFINITY) * self.std / self.value).exp();
        (self.value / factor, self.value * factor)
    }
}
