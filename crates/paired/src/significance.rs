//! Whether a quantity is one by its uncertainty.

use common::Quantity;
use estimate::stats;

/// Probability of a quantity so far from zero by chance.
pub fn p_of(quantity: &Quantity) -> f64 {
    stats::two_sided_p(quantity.value() / quantity.std().unwrap_or(f64::INFINITY), f64::INFINITY)
}
