//! Noise of a reading.

use common::{Axis, Document, Noise, SensorNoise};
use physics::Unit;

/// Length of a table of which it is not known beforehand, s: flicker noise counts down to one over it.
pub const DAY_S: f64 = 86_400.0;

/// Variance of one reading of a sensor as field, nT²: white noise, flicker noise from one over the series'
/// length to half the rate, and the width of a code squared over 12. The noise is that which sensorcal found,
/// in its absence what the makers state.
pub fn variance_nt2(
    document: &Document,
    axis: Axis,
    unit: Unit,
    sensitivity: f64,
    length_and_step_s: Option<[f64; 2]>,
) -> f64 {
    let instrument = document.instrument.as_ref();
    let width = unit.code_width(instrument);
    let code_nt = width.unwrap_or(0.0) * sensitivity;
    let rms = |noise: &Noise| match length_and_step_s {
        Some([length_s, step_s]) => noise.rms_nt(length_s, step_s),
        None => noise.white_rms_nt.unwrap_or(0.0),
    };
    let found =
        document.calibration.as_ref().and_then(|calibration| calibration.sensor(axis)?.noise.as_deref());
    let noise_nt = found
        .map(SensorNoise::as_noise)
        .as_ref()
        .or(instrument.and_then(|instrument| instrument.noise_of(axis)))
        .map_or(0.0, rms);
    noise_nt * noise_nt + code_nt * code_nt / 12.0
}

/// Length of a series and time from one sample to the next, the median, s.
pub fn length_and_step_s(time_s: &[f64]) -> Option<[f64; 2]> {
    let mut steps: Vec<f64> =
        time_s.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    if steps.is_empty() {
        return None;
    }
    let middle = steps.len() / 2;
    let step_s = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    Some([time_s[time_s.len() - 1] - time_s[0] + step_s, step_s])
}
