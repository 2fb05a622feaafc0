//! Series that tests make.

use noise::{Stream, power_law};

/// White noise.
pub fn white(stream: &mut Stream, count: usize, std: f64) -> Vec<f64> {
    (0..count).map(|_| std * stream.normal()).collect()
}

/// Flicker and white noise, cut out of a longer record, as every real one is.
pub fn made(
    stream: &mut Stream,
    (count, step_s): (usize, f64),
    (amplitude, exponent): (f64, f64),
    white: f64,
) -> Vec<f64> {
    let mut samples = power_law(stream, 16 * count, step_s, amplitude, exponent);
    samples.truncate(count);
    samples.iter_mut().for_each(|x| *x += white * stream.normal());
    samples
}
