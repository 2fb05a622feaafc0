use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{
    Budget, CrossFieldFit, Departure, ErrorBudget, Extra, Findings, OffsetDrift, Quantity, ReversalOffset,
    SensorNoise, TemperatureFit,
};

/// One sensor: B = k V + O, the field along the sensor's own axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SensorCalibration {
    /// Sensitivity k, nT/V.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensitivity_nt_per_v: Option<Quantity>,
    /// Sensitivity of an instrument that gives field (1 where absent).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensitivity_nt_per_nt: Option<Quantity>,
    /// Offset O, nT.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_nt: Option<Quantity>,
    /// Covariance of the keys in `covariance_order`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<Vec<Vec<f64>>>,
    /// The keys that `covariance` runs over.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance_order: Option<Vec<String>>,
    /// How k and O were found in a coil's field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensitivity: Option<Box<SensitivityFit>>,
    /// Offset by turning the sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reversal: Option<Box<ReversalOffset>>,
    /// Noise in a shield.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<Box<SensorNoise>>,
    /// Offsets from date to date.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift: Option<Box<OffsetDrift>>,
    /// What temperatures do to k and O.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature: Option<Box<TemperatureFit>>,
    /// What fields across the sensor do to k and O.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross_field: Option<Box<CrossFieldFit>>,
    /// What a measured field is uncertain by.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub budget: Vec<ErrorBudget>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// How a sensor's sensitivity was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct SensitivityFit {
    /// The recordings.
    pub recordings: Vec<String>,
    /// Readings used.
    pub readings: usize,
    /// `line`, or what was fitted beside it.
    pub model: String,
    /// Standard uncertainties from scatter (type A), and from coil and temperatures, common to all points
    /// (type B), by key.
    pub uncertainty: IndexMap<String, Budget>,
    /// The offset that this fit gives, nT; `offset_nt` joins it with the reversals'.
    pub offset_nt: Quantity,
    /// Polynomials from the line up, and why the order was chosen.
    pub orders: Vec<PolynomialOrder>,
    /// The order in words.
    pub order: String,
    /// What was looked for beside the line.
    pub departures: Vec<Departure>,
    /// Departures that would have explained the readings about as well as one that is fitted.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rivals: Vec<String>,
    /// Noise of the fit.
    pub noise: FitNoise,
    /// Whether the residuals are normal (Anderson and Darling).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normality: Option<TestResult>,
    /// Whether their signs come in runs (Wald and Wolfowitz).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runs: Option<TestResult>,
    /// Readings that no longer follow the field; they are not in the fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub saturation: Option<Saturation>,
    /// Every reading that was used.
    pub residuals: SensitivityResiduals,
    /// What looks wrong, in words.
    #[serde(flatten)]
    pub findings: Findings,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A polynomial of the applied field.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PolynomialOrder {
    /// Its order; 1 is the line.
    pub order: usize,
    /// Rms of its residuals, nT.
    pub rms_nt: f64,
    /// Probability of its last term by chance, beside the lower ones.
    pub p_value: f64,
}

/// Readings that no longer follow the field.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Saturation {
    /// The reading at which the output stands, in the unit of the recording: below, above.
    pub readings: [Option<f64>; 2],
    /// The applied field at which that begins, nT: below, above.
    pub fields_nt: [Option<f64>; 2],
    /// How many readings.
    pub count: usize,
}

/// The readings as columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct SensitivityResiduals {
    /// Number of the recording, from 0.
    pub recording: Vec<usize>,
    /// Applied field along the sensor, nT.
    pub field_nt: Vec<f64>,
    /// What was read, in the unit of the recording.
    pub reading: Vec<f64>,
    /// What was read as field less the applied one, by the line alone, nT.
    pub deviation_nt: Vec<f64>,
    /// The same by all that is fitted, nT.
    pub residual_nt: Vec<f64>,
}

/// Noise on which the intervals of a fit rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TestResult {
    /// The statistic.
    pub statistic: f64,
    /// Probability of a larger one by chance.
    pub p_value: f64,
}
