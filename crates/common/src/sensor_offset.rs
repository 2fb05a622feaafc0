use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{Extra, Findings, FitNoise, Quantity};

/// Offset of a sensor by turning it through 180° in a shield.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ReversalOffset {
    /// O, over all recordings, nT.
    pub offset_nt: Quantity,
    /// From standard uncertainty to 95 % interval.
    pub coverage_factor_95: f64,
    /// Each recording.
    pub recordings: Vec<Reversal>,
    /// What a turn that is not quite 180° may do.
    pub imperfect_turn: ImperfectTurn,
    /// What looks wrong, in words.
    #[serde(flatten)]
    pub findings: Findings,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// One recording of reversals.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Reversal {
    /// The recording.
    pub recording: String,
    /// O = −k (V₁ + V₂)/2, nT, at the reference temperatures where its temperature is known.
    pub offset_nt: Quantity,
    /// Field of the shield along the sensor in position +1, nT.
    pub shield_field_nt: Quantity,
    /// Drift of that field, nT/s, taken off; absent without times.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shield_drift_nt_per_s: Option<Quantity>,
    /// The pairs.
    pub pairs: ReversalPairs,
    /// Noise of the fit.
    pub noise: FitNoise,
}

/// Pairs of a reversal as columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ReversalPairs {
    /// Row of the first reading.
    pub row: Vec<usize>,
    /// Offset from the two readings, the drift of the shield's field taken off, nT.
    pub offset_nt: Vec<f64>,
    /// Whether it belongs to the rest (Grubbs, p < 0.001) and was used.
    pub used: Vec<bool>,
}

/// Bound of the error of a turn that is not quite 180°.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ImperfectTurn {
    /// How far the turn may miss 180°, deg.
    pub angle_deg: f64,
    /// Field across the sensor, nT; absent where no other sensor shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub field_across_nt: Option<f64>,
    /// Largest error of the offset, nT: B∥ (1 − cos ε)/2 + B⊥ sin ε/2; without B⊥, for the first part alone.
    pub bound_nt: f64,
    /// What each nT across the sensor adds to it, nT.
    pub bound_per_nt_across: f64,
}

/// Offsets from date to date.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct OffsetDrift {
    /// The dates as columns.
    pub dates: DriftDates,
    /// Mean of the offsets, nT.
    pub mean_nt: Quantity,
    /// Rms of the offsets about their mean, nT.
    pub rms_nt: f64,
    /// The same less what the dates' own uncertainties explain, nT.
    pub own_rms_nt: f64,
    /// Trend, nT per year of 365.25 days.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trend_nt_per_year: Option<Quantity>,
    /// Probability of such a trend by chance, under correlated noise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trend_p: Option<f64>,
    /// From the standard uncertainty of the trend to an interval that holds it in at least 95 %; other
    /// quantities have their own.
    pub coverage_factor_95: f64,
    /// The same under each noise alone, `white`, `flicker`, `random_walk`; and by least squares
    /// with the uncertainty of Newey and West, `newey_west`.
    pub trend_by_noise_nt_per_year: IndexMap<String, Quantity>,
    /// A cos(2π t/a) + B sin(2π t/a), t from the first date, where the dates span enough of a year.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub annual: Option<AnnualTerm>,
    /// What follows the sensor's temperature, nT/K, where it was recorded and moved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature_nt_per_k: Option<Quantity>,
    /// Probability of each noise with memory, `flicker` and `random_walk`.
    pub noise: IndexMap<String, f64>,
    /// What looks wrong, in words.
    #[serde(flatten)]
    pub findings: Findings,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A yearly term.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AnnualTerm {
    /// A, nT.
    pub cosine_nt: Quantity,
    /// B, nT.
    pub sine_nt: Quantity,
    /// √(A² + B²), nT.
    pub amplitude_nt: f64,
    /// Probability of such an amplitude by chance, under correlated noise.
    pub p_value: f64,
}

/// The dates of a drift as columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct DriftDates {
    /// The recording.
    pub recording: Vec<String>,
    /// Days since the first.
    pub time_d: Vec<f64>,
    /// Offset, nT.
    pub offset_nt: Vec<f64>,
    /// Its standard uncertainty, nT.
    pub std_nt: Vec<f64>,
    /// What is left by trend, yearly term and temperature, nT.
    pub residual_nt: Vec<f64>,
    /// Mean temperature of the sensor, degC, where it was recorded.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sensor_temperature_c: Vec<f64>,
}
