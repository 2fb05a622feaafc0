#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How two magnetometers agree at one octave of averaging times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default)]
pub struct OctaveAgreement {
    /// Averaging time of the blocks of which neighbours were compared, s.
    pub averaging_s: f64,
    /// Differences of neighbouring blocks.
    pub differences: u64,
    /// η from the reference's x, y, z by these alone; absent where they are too few.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matrix: Option<[f64; 3]>,
    /// Its standard uncertainty, the differences taken as independent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std: Option<[f64; 3]>,
    /// Share of the square of the test's differences that the reference explains.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coherence: Option<f64>,
}
