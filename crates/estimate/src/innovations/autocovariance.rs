//! Autocovariance of stationary noise from its density.

use fourier::Complex;

use crate::Error;

/// The grid of frequencies is at least so many times finer than one over the length.
const FINER: usize = 8;
/// Points of the transform at least, and at most.
const LEAST_POINTS: usize = 1 << 16;
const MOST_POINTS: usize = 1 << 26;
/// Lags to a step, for times that are not even.
const BETWEEN: usize = 16;

/// r_m = ∫ P(f) cos(2π f m Δt) df from 0 to 1/(2 Δt), m = 0 … rows − 1, by the trapezoidal rule.
///
/// Of noise that is white only r_0 is given.
pub(super) fn autocovariance(
    density: &dyn Fn(f64) -> f64,
    rows: usize,
    step_s: f64,
) -> Result<Vec<f64>, Error> {
    let mut power = sampled(density, rows, step_s, 1)?;
    let first = power[0].re;
    if power.iter().all(|power| (power.re / first - 1.0).abs() <= 1e-12) {
        return Ok(vec![density(0.0) / (2.0 * step_s)]);
    }
    Ok(transformed(&mut power, rows))
}

/// The autocovariance at any lag up to a span, a cubic through four of its values at sixteenths of a step.
pub(super) struct Continuous {
    lags: Vec<f64>,
    spacing_s: f64,
}

impl Continuous {
    /// Of a density from 0 to 1/(2 Δt), and nothing above.
    pub(super) fn of(density: &dyn Fn(f64) -> f64, span_s: f64, step_s: f64) -> Result<Self, Error> {
        let steps = (span_s / step_s).ceil() + 1.0;
        if steps * ((BETWEEN * FINER) as f64) > MOST_POINTS as f64 {
            return Err(Error::Series("over more than half a million steps at uneven times"));
        }
        let mut power = sampled(density, steps as usize, step_s, BETWEEN)?;
        let lags = transformed(&mut power, (steps as usize + 1) * BETWEEN);
        Ok(Self { lags, spacing_s: step_s / BETWEEN as f64 })
    }

    pub(super) fn at(&self, lag_s: f64) -> f64 {
        let place = lag_s.abs() / self.spacing_s;
        let below = place.floor();
        let t = place - below;
        let value = |offset: isize| self.lags[(below as isize + offset).unsigned_abs()];
        let (u, v, w) = (t + 1.0, t - 1.0, t - 2.0);
        (value(2) * u * t * v - value(-1) * t * v * w) / 6.0
            + (value(0) * u * v * w - value(1) * u * t * w) / 2.0
    }
}

/// P(f) df/2 at even frequencies from 0 to 1/(2 Δt), then zeros as far as lags of Δt/`between` need.
fn sampled(
    density: &dyn Fn(f64) -> f64,
    rows: usize,
    step_s: f64,
    between: usize,
) -> Result<Vec<Complex<f64>>, Error> {
    if !(step_s > 0.0 && step_s.is_finite()) {
        return Err(Error::Series("with a step that is not above zero"));
    }
    let points = (FINER * rows * between).next_power_of_two().max(LEAST_POINTS);
    let spacing_hz = between as f64 / (points as f64 * step_s);
    let highest = points / between / 2;
    let mut power = vec![Complex::new(0.0, 0.0); points / 2 + 1];
    for (k, power) in power.iter_mut().enumerate().take(highest + 1) {
        let frequency_hz = k as f64 * spacing_hz;
        let found = density(frequency_hz);
        if !(found > 0.0 && found.is_finite()) {
            return Err(Error::Density { frequency_hz, found });
        }
        power.re = found * spacing_hz / 2.0;
    }
    if between > 1 {
        // The transform takes the ends of its own grid by half; this end lies within it.
        power[highest].re /= 2.0;
    }
    Ok(power)
}

fn transformed(power: &mut [Complex<f64>], lags: usize) -> Vec<f64> {
    let points = 2 * (power.len() - 1);
    let mut values = vec![0.0; points];
    let transform = fourier::inverse(points);
    transform.process(power, &mut values).expect("buffers of the plan's lengths, real ends");
    values.truncate(lags);
    values
}
