//! What is the same in the white noise of series.

/// What all series have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum White {
    /// The rms of a reading, σ.
    PerReading,
    /// The density N, from which a reading of a series has the rms √(N/(2 Δt)).
    Density,
    /// Nothing: each series has its own rms of a reading.
    Each,
}

impl White {
    /// Density of a white variance of one (unit²/Hz) in readings `step_s` apart.
    pub(super) fn density(self, step_s: f64) -> f64 {
        if self == White::Density { 1.0 } else { 2.0 * step_s }
    }
}
