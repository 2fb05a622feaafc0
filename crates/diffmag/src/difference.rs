//! The difference d = T − R η of one axis: its noise.

use common::{AllanDeviation, DifferenceAxis, Quantity};
use estimate::periodogram::periodogram;
use estimate::whittle::{self, Estimate, WhittleFit};
use estimate::{allan, stats};

use crate::Error;

/// The noise of a difference, with the density that weighs a regression.
pub struct Noise {
    fit: WhittleFit,
    step_s: f64,
}

impl Noise {
    /// A/f^α + white, by maximum likelihood.
    pub fn of(difference: &[f64], step_s: f64) -> Result<Self, Error> {
        let fit = whittle::fit(&[periodogram(difference, step_s)?])?;
        Ok(Self { fit, step_s })
    }

    /// Its one-sided density, nT²/Hz.
    pub fn density(&self, frequency_hz: f64) -> f64 {
        self.fit.density(0, self.step_s, frequency_hz).value
    }
}

/// What is said of one axis.
pub fn describe(difference: &[f64], noise: &Noise) -> Result<DifferenceAxis, Error> {
    let count = difference.len() as f64;
    let mean = difference.iter().sum::<f64>() / count;
    let freedom = count - 4.0;
    let squares: f64 = difference.iter().map(|d| (d - mean).powi(2)).sum();
    let bound = |p: f64| (squares / stats::chi_squared_quantile(p, freedom)).sqrt();
    let quantity = |estimate: Estimate| Quantity::new(estimate.value, estimate.std);
    let fit = &noise.fit;
    let points = allan::overlapping(difference, noise.step_s, |averaging_s| {
        let frequency = 0.5 / averaging_s;
        let white = 2.0 * fit.white_rms[0].value.powi(2) * noise.step_s;
        if fit.flicker_density(frequency).value > white { fit.exponent.value } else { 0.0 }
    })?;
    let mut columns = AllanDeviation::default();
    for point in &points {
        let (low, high) = point.interval(0.95);
        columns.series.push(0);
        columns.averaging_s.push(point.averaging_s);
        columns.deviation_nt.push(point.deviation);
        columns.low_nt.push(point.deviation * low);
        columns.high_nt.push(point.deviation * high);
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
