//! What the fits of a sensor rest on.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Noise on which the intervals of a fit rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default)]
pub struct FitNoise {
    /// `measured` (this document's `sensor_noise`), `declared` (`instrument.noise`), either `with that of the
    /// field`, `residuals` (white and flicker in every proportion, averaged by likelihood).
    pub source: String,
    /// Rms of the residuals, nT.
    pub rms_nt: f64,
    /// Variance of the residuals over what the sensor's own noise promises, where that is measured or
    /// declared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variance_factor: Option<f64>,
    /// Share of flicker noise and random walk in the variance of a reading.
    pub flicker_share: f64,
    /// Degrees of freedom.
    pub degrees_of_freedom: f64,
    /// From standard uncertainty to 95 % interval.
    pub coverage_factor_95: f64,
}

/// A test with its probability.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct TestResult {
    /// The statistic.
    pub statistic: f64,
    /// Probability of a larger one by chance.
    pub p_value: f64,
}
