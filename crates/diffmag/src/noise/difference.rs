//! The difference d = T − R η of one axis, as a document has it.

use common::{AllanDeviation, DifferenceAxis, Quantity};
use estimate::allan::Deviations;
use estimate::stats;
use estimate::whittle::Estimate;
use paired::noise::Noise;

use crate::Error;

/// What is said of one axis; `source` is the difference of the source's fit, with its drift in it.
pub fn describe(
    difference: &[f64],
    source: &[f64],
    noise: &Noise,
    step_s: f64,
) -> Result<DifferenceAxis, Error> {
    let freedom = source.len() as f64 - 4.0;
    let squares: f64 = source.iter().map(|d| d * d).sum();
    let bound = |p: f64| (squares / stats::chi_squared_quantile(p, freedom)).sqrt();
    let quantity = |estimate: Estimate| Quantity::new(estimate.value, estimate.std);
    let fit = noise.fitted();
    let mut columns = AllanDeviation::default();
    for point in Deviations::of(difference, step_s)?.of_noise(fit) {
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
