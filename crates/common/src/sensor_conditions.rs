use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{Departure, Extra, FTest, Findings, FitNoise, Quantity, TestResult};

/// What temperatures do to a sensor's sensitivity and offset.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct TemperatureFit {
    /// The recordings.
    pub recordings: Vec<String>,
    /// Temperatures from which changes count, degC: sensor, electronics.
    pub reference_c: [Option<f64>; 2],
    /// What follows the sensor's temperature.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<TemperatureOfPart>,
    /// What follows the electronics' temperature.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub electronics: Option<TemperatureOfPart>,
    /// What was looked for besides: cubic terms, differences of the branches, the product of both
    /// temperatures.
    pub departures: Vec<Departure>,
    /// The temperatures that were held, as columns.
    pub levels: TemperatureLevels,
    /// Covariance of the parameters in `covariance_order`.
    pub covariance: Vec<Vec<f64>>,
    /// `sensor.sensitivity_ppm_per_k` and so on.
    pub covariance_order: Vec<String>,
    /// Noise of the fit.
    pub noise: FitNoise,
    /// What looks wrong, in words.
    #[serde(flatten)]
    pub findings: Findings,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// What one temperature does: k(T) and O(T) are those at the reference with these changes of the reading's
/// field.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct TemperatureOfPart {
    /// Lowest and highest temperature, degC.
    pub range_c: [f64; 2],
    /// dB/B for each K at the reference, ppm/K.
    pub sensitivity_ppm_per_k: Quantity,
    /// dB/B for each K², ppm/K²; absent with less than three temperatures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensitivity_ppm_per_k2: Option<Quantity>,
    /// Probability of that curvature by chance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensitivity_curvature_p: Option<f64>,
    /// dB for each K at the reference, nT/K.
    pub offset_nt_per_k: Quantity,
    /// dB for each K², nT/K²; absent with less than three temperatures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset_nt_per_k2: Option<Quantity>,
    /// Probability of that curvature by chance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset_curvature_p: Option<f64>,
    /// The report's slopes through the three temperatures around the reference: ppm/K and nT/K.
    pub three_point: IndexMap<String, Quantity>,
    /// Time by which the change follows the temperature, s, where the readings show one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lag_s: Option<Quantity>,
    /// What the readings say about such a lag, in words.
    pub lag: String,
    /// Temperatures at which k and O do not change, degC.
    pub extrema_c: IndexMap<String, Quantity>,
}

/// A temperature at which k or O of all sensors stand still.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CommonExtremum {
    /// `sensor` or `electronics`.
    pub part: String,
    /// `sensitivity` or `offset`.
    pub quantity: String,
    /// The temperature, degC.
    pub temperature_c: Quantity,
    /// Probability of larger differences between the sensors by chance.
    pub p_value: f64,
}

/// k and O at each temperature that was held, as columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct TemperatureLevels {
    /// Number of the recording, from 0.
    pub recording: Vec<usize>,
    /// Mean temperature of the sensor, degC.
    pub sensor_temperature_c: Vec<f64>,
    /// Mean temperature of the electronics, degC.
    pub electronics_temperature_c: Vec<f64>,
    /// +1 where the temperature that moves had risen before, −1 where it had fallen.
    pub branch: Vec<i8>,
    /// k at this temperature, in the unit of the recording.
    pub sensitivity: Vec<f64>,
    /// Its standard uncertainty from scatter.
    pub sensitivity_std: Vec<f64>,
    /// O at this temperature, nT.
    pub offset_nt: Vec<f64>,
    /// Its standard uncertainty from scatter, nT.
    pub offset_std_nt: Vec<f64>,
}

/// What fields across a sensor do to its sensitivity and offset.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct CrossFieldFit {
    /// The recordings.
    pub recordings: Vec<String>,
    /// Whether k and O differ between the fields across, once a misaligned sensor is allowed for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub difference: Option<FTest>,
    /// Parameters of the catalogue's `cross_field`, by key, nT at 50 000 nT across.
    pub offset: IndexMap<String, Quantity>,
    /// Parameters of the catalogue's `cross_field_sensitivity`, by key, nT at 50 000 nT along and across.
    pub sensitivity: IndexMap<String, Quantity>,
    /// Covariance of the parameters in `covariance_order`.
    pub covariance: Vec<Vec<f64>>,
    /// `offset.first_nt` and so on.
    pub covariance_order: Vec<String>,
    /// What was looked for besides.
    pub departures: Vec<Departure>,
    /// Fields across as columns.
    pub levels: CrossFieldLevels,
    /// By how much each sensor points towards the coil across it; it belongs to the axes.
    pub misalignments: Vec<Misalignment>,
    /// What the correction does to readings that were not in its fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held_out: Option<HeldOut>,
    /// Noise of the fit.
    pub noise: FitNoise,
    /// Whether any of it is significant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub significance: Option<TestResult>,
    /// What looks wrong, in words.
    #[serde(flatten)]
    pub findings: Findings,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// k and O at each field across, as columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct CrossFieldLevels {
    /// Number of the recording, from 0.
    pub recording: Vec<usize>,
    /// The coil across, `x`, `y` or `z`.
    pub coil: Vec<String>,
    /// Its field, nT.
    pub across_nt: Vec<f64>,
    /// k, in the unit of the recording.
    pub sensitivity: Vec<f64>,
    /// Its standard uncertainty from scatter.
    pub sensitivity_std: Vec<f64>,
    /// O, nT, with what a misaligned sensor adds.
    pub offset_nt: Vec<f64>,
    /// Its standard uncertainty from scatter, nT.
    pub offset_std_nt: Vec<f64>,
}

/// A sensor's direction towards a coil across it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Misalignment {
    /// The recording.
    pub recording: String,
    /// The coil.
    pub coil: String,
    /// Angle by which the sensor's axis leans towards its field, arcsec.
    pub angle_arcsec: Quantity,
}

/// Rms of readings that were left out of a fit, nT.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HeldOut {
    /// With the constants and the lean alone.
    pub before_nt: f64,
    /// Corrected for the field across as it was applied.
    pub after_nt: f64,
    /// Corrected in the report's first pass, for the field across as the sensors read it with their constants
    /// alone; absent where a recording does not have the readings of all three.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_pass_nt: Option<f64>,
    /// Corrected in the second pass, for the field across as the readings corrected in the first one give it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_pass_nt: Option<f64>,
    /// Readings.
    pub readings: usize,
}
