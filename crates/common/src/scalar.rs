use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{Extra, Findings, Noise, PerAxis, Quantity};

/// How the sensors were calibrated by the magnitude of the field, by scalarcal. The calibration itself stands
/// under `sensors` and `axes.sensors`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ScalarCalibration {
    /// The recordings.
    pub recordings: Vec<String>,
    /// Rows used.
    pub rows: u64,
    /// Rows that lack a reading.
    #[serde(skip_serializing_if = "is_zero")]
    pub missing: u64,
    /// Rows that were left out, by the reason.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub left_out: IndexMap<String, u64>,
    /// Where the field comes from, in words.
    pub reference: String,
    /// What the direction of the field says, where it was used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vector: Option<VectorFit>,
    /// Rms of the residual |B| − F after the fit, nT.
    pub rms_nt: f64,
    /// The same with the calibration as the document stated it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_before_nt: Option<f64>,
    /// Noise of the residual.
    pub noise: Noise,
    /// Whose memory that is, where the noise has one: `sensors`, or `magnitude`, which changed while nobody
    /// measured it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory_of: Option<String>,
    /// Noise of a sensor that was allowed for, nT rms.
    pub sensor_noise_nt: f64,
    /// Noise of the reference, nT rms.
    pub reference_noise_nt: f64,
    /// Every parameter that was fitted.
    pub parameters: Vec<ScalarParameter>,
    /// How many combinations of the parameters the readings determine.
    pub rank: usize,
    /// What the readings show least.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weakest: Option<WeakestDirection>,
    /// The constant error of the reference that the readings ask for, nT, whether it was fitted or not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_offset: Option<ReferenceOffset>,
    /// How the calibration departs from what was known beforehand.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beforehand: Option<AgainstKnown>,
    /// The calibration in parts of the time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stability: Option<ScalarStability>,
    /// Directions of the field in SEN with the residual there, for plots.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directions: Option<FieldDirections>,
    /// Whether offsets, sensitivities and directions include what iron that turns with the sensors adds: true
    /// but for sensors away from their body (`conditions.mounted: false`).
    pub includes_body: bool,
    /// The iron of the body by itself, where the recordings show it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyIron>,
    /// What looks wrong, in words.
    #[serde(flatten)]
    pub findings: Findings,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The readings against a field that is known with its direction.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct VectorFit {
    /// Moments at which field and attitude are known.
    pub moments: u64,
    /// Rms of the residual along the field, nT.
    pub rms_along_nt: f64,
    /// The same across it, of one component.
    pub rms_across_nt: f64,
    /// Error of the attitude about one axis that explains the difference of the two, arcsec.
    pub attitude_std_arcsec: f64,
    /// Whether only the residual across the field was used, beside a scalar magnetometer.
    pub across_only: bool,
    /// Noise of these residuals, where it was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
    /// What the noise with memory belongs to, where there is some: `sensors`, or `field`, the components of
    /// the known field in GEO.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub memory_of: Option<String>,
}

/// Iron that turns with the sensors: it makes HB + h of the field B. The magnitude does not show a turn
/// within H, of which the symmetric part is given.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct BodyIron {
    /// h, the field of what is magnetised, in SEN, nT.
    pub hard_iron_nt: PerAxis<Quantity>,
    /// H − 1, what the field magnetises: the elements xx, yy, zz, xy, yz, xz in SEN, ppm.
    pub soft_iron_ppm: IndexMap<String, Quantity>,
    /// χ² of all of it against none.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: f64,
    /// Probability of as much by chance if the body has no iron.
    pub p_value: f64,
}

/// One fitted parameter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ScalarParameter {
    /// What it is.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The estimate.
    pub value: f64,
    /// Its standard uncertainty.
    pub std: f64,
    /// The same by the readings alone, without what is known beforehand; absent: the readings do not
    /// determine it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std_alone: Option<f64>,
    /// The same with what is known beforehand, where something is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std_with_known: Option<f64>,
}

/// The combination of parameters that the readings show least.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct WeakestDirection {
    /// Share of each parameter, largest one; sensitivities and cosines as they are, offsets over the
    /// magnitude.
    pub shares: IndexMap<String, f64>,
    /// Standard uncertainty of the combination by the readings alone, as field, nT.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std_nt: Option<f64>,
    /// In words.
    pub words: String,
    /// The further rotation that would show it best.
    pub remedy: String,
    /// Standard uncertainty of the combination after as many readings again, turned so, as field, nT.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std_after_nt: Option<f64>,
}

/// A constant error of the reference.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ReferenceOffset {
    /// What the reference reads too much, nT.
    pub offset_nt: Quantity,
    /// Probability of as much by chance if it reads right.
    pub p_value: f64,
    /// Whether it is in the fit.
    pub fitted: bool,
}

/// The readings against what was known.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AgainstKnown {
    /// χ² of the difference.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: f64,
    /// Probability of as much by chance.
    pub p_value: f64,
    /// Whether what was known is in the fit.
    pub used: bool,
}

/// Whether the calibration holds over the time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ScalarStability {
    /// The parts.
    pub windows: Vec<ScalarWindow>,
    /// χ² of the parameters of the parts about those of all.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: f64,
    /// Probability of as much by chance.
    pub p_value: f64,
}

/// The calibration in a part of the time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ScalarWindow {
    /// From, s.
    pub from_s: f64,
    /// To, s.
    pub to_s: f64,
    /// Rows.
    pub rows: u64,
    /// Rms of the residual, nT.
    pub rms_nt: f64,
    /// The parameters, in the order of `parameters`; none where the part does not determine them.
    pub values: Vec<f64>,
    /// Their standard uncertainties, by the part alone.
    pub std: Vec<f64>,
}

/// Where in SEN the field lay, a part of the rows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct FieldDirections {
    /// Unit vectors in SEN.
    pub unit: Vec<[f64; 3]>,
    /// Residual |B| − F, nT.
    pub residual_nt: Vec<f64>,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}
