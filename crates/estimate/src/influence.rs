//! Leverage and leave-one-out, without fitting again (Cook & Weisberg 1982, ch. 2).

use crate::Fit;
use crate::stats;

/// What one reading does to the fit, and the fit to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influence {
    /// Share of the prediction that the reading itself decides, 0 to 1.
    pub leverage: f64,
    /// Reading less the prediction made without it: e/(1 − h), in standard deviations.
    pub leave_one_out: f64,
    /// Externally studentised residual e/(s₍ᵢ₎ √(1 − h)), s₍ᵢ₎ estimated without the reading.
    pub t: f64,
}

/// Influence of the first `readings` rows of a fit.
///
/// With `known_scale` s₍ᵢ₎ is never taken below 1: a reading is called far out only when it is so for the
/// declaration *and* for the others. `left_out` of the rows have weight zero and do not count.
pub fn influence<S>(fit: &Fit<S>, readings: usize, known_scale: bool, left_out: usize) -> Vec<Influence> {
    let freedom = fit.degrees_of_freedom() - left_out as f64;
    let leverage = fit.svd.leverage();
    (0..readings)
        .map(|i| {
            let (h, e) = (leverage[i].min(1.0), fit.residual[i]);
            let rest = 1.0 - h;
            // A reading that alone decides its prediction fits whatever it is: nothing can be said of it.
            if rest < 1e-9 || freedom <= 1.0 {
                return Influence { leverage: h, leave_one_out: 0.0, t: 0.0 };
            }
            let variance = ((fit.cost - e * e / rest) / (freedom - 1.0)).max(0.0);
            let scale = if known_scale { variance.max(1.0) } else { variance };
            let t = if scale > 0.0 { e / (scale * rest).sqrt() } else { 0.0 };
            Influence { leverage: h, leave_one_out: e / rest, t }
        })
        .collect()
}

/// Probability that the largest |t| of `readings` is at least `t` when nothing is wrong (Bonferroni).
pub fn adjusted_p(t: f64, freedom: f64, readings: usize) -> f64 {
    (stats::two_sided_p(t, freedom) * readings as f64).min(1.0)
}
