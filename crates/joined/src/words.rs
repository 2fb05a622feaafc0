//! What was done to times, in words.

use common::number::{bare, significant};

/// Times that were made even.
pub fn uneven(id: &str, scatter_s: f64, step_s: f64) -> String {
    format!(
        "\"{id}\": its times are uneven by up to {} s; its readings were interpolated to steps of {} s, which attenuates their noise unevenly",
        significant(scatter_s, 2),
        bare(step_s)
    )
}

/// An instrument that was brought to another grid.
pub fn filtered(instrument: &str, from_s: f64, to_s: f64, white: f64) -> String {
    format!(
        "the {instrument} instrument's readings, {} s apart, were filtered to the grid of {} s: {} % of the rms of its white noise passes, and the noise is estimated below 0.9 of half the sampling rate",
        bare(from_s),
        bare(to_s),
        significant(100.0 * white, 2)
    )
}
