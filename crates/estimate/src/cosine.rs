//! Linear regression of long even series whose errors have a power-law spectrum and are not periodic.
//!
//! The cosine transform goes on with a series as its mirror image, so that neither a drift nor noise with
//! memory jumps at the ends. What is slow is where it matters, and there the covariance is exact.

use crate::cross_spectrum::{WIDEST_BIN, bins};
use crate::periodogram::{Bin, Periodogram};
use crate::whittle::WhittleFit;

mod errors;
mod regression;
mod transform;

pub use errors::Errors;
pub use regression::{Projection, Regression, regress, weighted};
pub use transform::Cosine;

/// What of an ordinate a regression leaves, at least, for it to say something of the noise.
const LEFT: f64 = 1e-6;

impl Cosine {
    /// What a regression leaves as ordinates I = 2Δt c_k² of the noise, each over the share 1 − h of its
    /// variance that is left and with half that share as its count; not those `left_out`.
    ///
    /// Source: A. P. Verbyla, Modelling variance heterogeneity: residual maximum likelihood and diagnostics,
    /// J. R. Stat. Soc. B 55 (1993) 493–508.
    pub fn ordinates(
        &self,
        regression: &Regression,
        errors: &Errors,
        left_out: impl Fn(f64) -> bool,
    ) -> Periodogram {
        let mut bins: Vec<Bin> = Vec::new();
        let mut first = 0;
        for (row, residual) in regression.residual.iter().enumerate() {
            let (k, frequency_hz) = (row + 1, self.frequency(row + 1));
            let left = 1.0 - regression.leverage[row];
            if left < LEFT || left_out(frequency_hz) {
                continue;
            }
            let exact = errors.nominal.get(row).map_or(1.0, |nominal| nominal / errors.variance[row]);
            let (power, count) = (self.step_s * residual * residual * exact, 0.5 * left);
            match bins.last_mut().filter(|_| k < first + ((WIDEST_BIN * first as f64) as usize).max(1)) {
                // Until the bin is whole, sums: of the power, and of count times frequency.
                Some(bin) => {
                    bin.density += power;
                    bin.frequency_hz += count * frequency_hz;
                    bin.count += count;
                }
                None => {
                    first = k;
                    bins.push(Bin { frequency_hz: count * frequency_hz, density: power, count });
                }
            }
        }
        for bin in &mut bins {
            bin.frequency_hz /= bin.count;
            bin.density /= bin.count;
        }
        Periodogram {
            length_s: self.rows as f64 * self.step_s,
            step_s: self.step_s,
            samples: self.rows,
            mirrored: false,
            bins,
            lines: Vec::new(),
        }
    }

    /// Degrees of freedom of the variance of a linear estimate from the squares of its whitened weights,
    /// summed over [`bins`]: 2/u², u the relative uncertainty of that variance from the uncertainty of the
    /// noise, `relative_std` at each frequency, taken as common to all; at least one.
    ///
    /// Source: F. E. Satterthwaite, An approximate distribution of estimates of variance components,
    /// Biometrics Bull. 2 (1946) 110–114.
    pub fn freedom(&self, relative_std: impl Fn(f64) -> f64, influence: &[f64]) -> f64 {
        let (mut sum, mut uncertain) = (0.0, 0.0);
        for (bin, squares) in bins(self.rows - 1, WIDEST_BIN).zip(influence) {
            sum += squares;
            uncertain += squares * relative_std(self.frequency(bin.start + 1));
        }
        (2.0 * (sum / uncertain).powi(2)).max(1.0)
    }
}

/// Standard uncertainty of the density over it; flicker noise that was not seen is taken as absent.
pub fn relative_std(noise: &WhittleFit, step_s: f64, frequency_hz: f64) -> f64 {
    if noise.amplitude.value > 0.0 {
        let density = noise.density(0, step_s, frequency_hz);
        density.std / density.value
    } else {
        noise.covariance[(2, 2)].sqrt() / noise.white_variances[0]
    }
}
