use common::{Calibration, Error, Facility, Instrument, Model, Noise, PerAxis, Versioned};
use serde::{Deserialize, Serialize};

use crate::differential::DifferentialTruth;
use crate::outside::{OutsidePlan, SitePlan};
use crate::procedures::Procedure;
use crate::timing::Timing;

/// What is to be simulated: the facility and the instrument as they are stated, what they truly are,
/// and the procedures in order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Format version, 1.
    pub fluxcal: u64,
    /// Free text; the document's title.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// Seed of all noise.
    #[serde(default)]
    pub seed: u64,
    /// When the campaign begins (RFC 3339, with the local offset from UTC). Absent: recordings carry no
    /// `start` and share the campaign's clock.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<String>,
    /// The facility, as the document will state it. Its uncertainties are also what the simulated
    /// theodolites, resistors, voltmeter and scalar reference err by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facility: Option<Facility>,
    /// The instrument, as the document will state it; its noise and quantisation are applied.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instrument: Option<Instrument>,
    /// The calibration that the document will state.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "common::calibration_of")]
    pub calibration: Option<Calibration>,
    /// What of `calibration` the stages are to find: it serves the operator for setting the drives and stays
    /// out of the document (`coils`, `sensors`, `axes`, `differential`).
    #[serde(default)]
    pub unstated: Vec<CalibrationPart>,
    /// How the drive is written: as current, or as the voltmeter reads it over the precision resistors.
    #[serde(default)]
    pub drive: DriveRecord,
    /// Temperatures of the rooms; absent: no temperature columns but in a temperature run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperatures: Option<Temperatures>,
    /// How long things take.
    #[serde(default)]
    pub timing: Timing,
    /// What is true; where it says nothing, what is stated is true.
    #[serde(default)]
    pub truth: TruthPlan,
    /// The procedures.
    pub procedures: Vec<Procedure>,
}

impl Versioned for Plan {
    fn format_version(&self) -> Option<u64> {
        Some(self.fluxcal)
    }
}

impl Plan {
    /// Reads a plan. Errors: no JSON, another version, a key that no plan has, a value that its key cannot have.
    pub fn parse(text: &str) -> Result<Self, Error> {
        common::parse(text)
    }
}

/// A part of the calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum CalibrationPart {
    /// Coil constants and offsets.
    Coils,
    /// Sensitivities and offsets.
    Sensors,
    /// Directions.
    Axes,
    /// One magnetometer against the other.
    Differential,
}

/// How the drive of the coils is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum DriveRecord {
    /// `coil_*_a`, exact.
    #[default]
    Current,
    /// `coil_*_v`, with the errors of resistor and voltmeter, the same through the whole campaign.
    Voltage,
}

/// Temperatures of the rooms, with a daily wave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Temperatures {
    /// Of the sensors, mean, degC.
    pub sensor_temperature_c: f64,
    /// Of the electronics, mean, degC.
    pub electronics_temperature_c: f64,
    /// Of the coils, mean, degC.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coil_temperature_c: Option<f64>,
    /// Half of the daily swing, K; warmest at 15 h.
    #[serde(default)]
    pub daily_k: f64,
    /// Slow change, K per day.
    #[serde(default)]
    pub trend_k_per_day: f64,
}

/// The truth behind the recordings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TruthPlan {
    /// True constants and axes.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "common::calibration_of")]
    pub calibration: Option<Calibration>,
    /// Effects that act on the readings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<Model>,
    /// Field at the sensors with no drive, GEO, nT.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual_field_nt: Option<PerAxis<f64>>,
    /// Field left in the shield, SEN, nT.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shield_field_nt: Option<PerAxis<f64>>,
    /// Field of each coil along its axis, for the survey of its gradient.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coil_profile: Option<PerAxis<Profile>>,
    /// How each sensor's offset wanders from date to date in `offset_drift`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_wander: Option<Noise>,
    /// The natural field outside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outside: Option<OutsidePlan>,
    /// Noise of the site by hour and weekday.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub site: Option<SitePlan>,
    /// The two magnetometers of a differential recording.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub differential: Option<DifferentialTruth>,
}

/// Field along a coil's axis over the field at its centre: 1 + (a x + b x² + c x⁴) 1e-6, x in m.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Profile {
    /// a.
    pub first_ppm_per_m: f64,
    /// b.
    pub second_ppm_per_m2: f64,
    /// c.
    pub fourth_ppm_per_m4: f64,
}

impl Profile {
    /// Field over the field at the centre.
    pub fn at(&self, x: f64) -> f64 {
        let ppm =
            self.first_ppm_per_m * x + self.second_ppm_per_m2 * x * x + self.fourth_ppm_per_m4 * x.powi(4);
        1.0 + ppm * 1e-6
    }
}
