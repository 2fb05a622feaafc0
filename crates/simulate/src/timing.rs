use serde::{Deserialize, Serialize};

/// How long things take, s.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Timing {
    /// After a change of the drive, before the reading.
    pub field_settle_s: f64,
    /// One reading.
    pub reading_s: f64,
    /// Setting up a procedure, or turning the block to another orientation and reading the theodolites once.
    pub orientation_s: f64,
    /// Reading the theodolites once more.
    pub theodolite_s: f64,
    /// After a change of temperature (NASA: about half an hour).
    pub temperature_settle_s: f64,
    /// Turning a sensor by 180°.
    pub reversal_s: f64,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            field_settle_s: 10.0,
            reading_s: 1.0,
            orientation_s: 900.0,
            theodolite_s: 180.0,
            temperature_settle_s: 1800.0,
            reversal_s: 60.0,
        }
    }
}
