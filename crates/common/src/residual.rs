//! What recordings leave beside a prediction: how much, where, and what it looks like.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{Extra, PlainRegression};

/// What is left may exceed what there was by rounding, not by so much.
pub(crate) const ABSURD: f64 = 1.01;

/// Rms of what is observed less what is predicted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Residual {
    /// With the document's calibration and model as they came, nT.
    pub rms_before_nt: f64,
    /// With the calibration alone fitted again, nT.
    pub rms_refitted_nt: f64,
    /// With the effects, nT.
    pub rms_after_nt: f64,
    /// Of readings left out of the fit, calibration alone, nT.
    pub held_out_before_nt: f64,
    /// Of readings left out of the fit, with the effects, nT.
    pub held_out_after_nt: f64,
    /// What the noise alone would leave, nT.
    pub noise_floor_nt: f64,
    /// `declared`, or `residuals` where it was estimated.
    pub noise_source: String,
    /// Each recording and sensor.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub by_recording: Vec<ResidualOf>,
    /// What plain regressions on the same columns predict of the same readings.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub plain: Vec<PlainRegression>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Residual {
    /// Whether a fit leaves more than there was: such a fit is worse than none.
    pub fn is_absurd(&self) -> bool {
        self.rms_refitted_nt.max(self.rms_after_nt) > ABSURD * self.rms_before_nt
    }
}

/// Rms of the residuals of one sensor in one recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ResidualOf {
    /// The recording.
    pub recording: String,
    /// The column of readings.
    pub column: String,
    /// With the document's calibration and model as they came, nT.
    pub rms_before_nt: f64,
    /// With the effects, nT.
    pub rms_after_nt: f64,
    /// Of readings left out of the fit, calibration alone, nT.
    pub held_out_before_nt: f64,
    /// Of readings left out of the fit, with the effects, nT.
    pub held_out_after_nt: f64,
    /// What the noise alone would leave, nT.
    pub noise_floor_nt: f64,
}

/// How much of the difference lies in a part of the readings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct EnergyShare {
    /// What the readings are parted by: `recording`, `sensor`, `time_s`, `band_hz`, or a covariate.
    pub by: String,
    /// The recording or the column of readings, where parted by those.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// The part's region, in the unit of what it is parted by.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Share of the excess of the weighted squared residual over what the noise leaves, with the calibration
    /// fitted again and before any effect. Shares of all parts sum to 1; one below zero has less than its
    /// noise.
    pub share: f64,
}

/// Residuals along something, for plots: each point a reading, or the mean of neighbouring ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ResidualSeries {
    /// The recording; absent: all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// The column of readings.
    pub column: String,
    /// What `x` is: `time_s` or a covariate.
    pub along: String,
    /// Where the points are.
    pub x: Vec<f64>,
    /// With the document's calibration and model as they came, nT.
    pub before_nt: Vec<f64>,
    /// With the effects, nT.
    pub after_nt: Vec<f64>,
    /// What a fitted term makes of `x`, nT; absent where none is drawn.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fitted_nt: Vec<f64>,
    /// The readings themselves, nT: along time.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub recorded_nt: Vec<f64>,
    /// By how much the residual is larger without an effect, all else as it was fitted, nT: by its label.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub contributions_nt: IndexMap<String, Vec<f64>>,
    /// Readings in each point; the last may have fewer.
    pub readings: usize,
}

/// What is left.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Remaining {
    /// Whether nothing is left but the noise.
    pub white: bool,
    /// Probability of a larger sum of squares under the declared noise; absent where the noise is not
    /// declared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_value: Option<f64>,
    /// Probability of the most striking structure by chance.
    pub p_adjusted: f64,
    /// What it looks like, in words.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub structure: String,
}
