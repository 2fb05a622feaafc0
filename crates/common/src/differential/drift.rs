use serde::{Deserialize, Serialize};

use crate::{Extra, Quantity};

/// The drift of the difference d along one axis of the test instrument: b t + a e^(−t/τ), t from the first
/// row.
///
/// A `std` is such that value ± 1.96 std is the 95 % interval of Student's t with the degrees of freedom that
/// the noise is known with.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Drift {
    /// What the readings demand. The straight part is always in the fit that the matrix is from, the
    /// exponential one only where it is demanded.
    pub demanded: DriftForm,
    /// Probability below which a drift is demanded.
    pub level: f64,
    /// b in the fit that the matrix is from, nT/day.
    pub straight_nt_per_day: Quantity,
    /// Probability of a straight drift as great by chance.
    pub straight_p: f64,
    /// Probability, over all time constants, of an exponential drift as great beside a straight one by
    /// chance.
    pub exponential_p: f64,
    /// Both parts together with the matrix under the fitted noise, demanded or not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint: Option<JointDrift>,
    /// Both parts as the source has it, where an exponential is significant: matrix and drift by least squares in turn
    /// until they stand.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iteration: Option<IteratedDrift>,
    /// A straight drift against noise with memory alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explanations: Option<DriftExplanations>,
    /// Means of the difference, with its drift, over equal windows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub windows: Vec<WindowMean>,
    /// Over a day after the recording. Absent where the statistics of pieces do not show it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_day: Option<DriftChange>,
    /// Over a month of 30.4375 days.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_month: Option<DriftChange>,
    /// Over a year of 365.25 days.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_year: Option<DriftChange>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Which drift there is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum DriftForm {
    /// None that noise alone would not show as often.
    #[default]
    None,
    /// b t.
    Straight,
    /// a e^(−t/τ).
    Exponential,
    /// b t + a e^(−t/τ).
    Both,
}

/// The joint fit: τ is the one unknown that is not linear.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct JointDrift {
    /// What the reference's x, y, z give to this axis, nT/nT.
    pub eta: [Quantity; 3],
    /// b, nT/day.
    pub straight_nt_per_day: Quantity,
    /// a, nT.
    pub amplitude_nt: Quantity,
    /// τ, s.
    pub time_constant_s: Quantity,
    /// 95 % interval of τ, even in its logarithm, within what is sought: ten steps and a thousandth of the
    /// recording to three times its length, s.
    pub time_constant_interval_s: [f64; 2],
    /// Whether τ was stopped by its limits.
    pub time_constant_at_limit: bool,
    /// Covariance of η, b (nT/day), a (nT) and ln τ.
    pub covariance: Vec<Vec<f64>>,
}

/// The source's way: η by least squares, the drift by least squares to T − R η, taken from T, again.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct IteratedDrift {
    /// Rounds until a further one moved the drift by less than 1e-9 of the difference.
    pub rounds: usize,
    /// Whether it came to stand.
    pub settled: bool,
    /// What the reference's x, y, z give to this axis, nT/nT.
    pub eta: [f64; 3],
    /// b, nT/day.
    pub straight_nt_per_day: f64,
    /// a, nT.
    pub amplitude_nt: f64,
    /// τ, s.
    pub time_constant_s: f64,
    /// How far η, b, a and ln τ are from the joint fit, in its standard uncertainties.
    pub from_joint_std: [f64; 6],
}

/// How much d changes over a span that begins where the recording ends.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct DriftChange {
    /// By the drift of the fit that the matrix is from, nT.
    pub drift_nt: Quantity,
    /// Rms of what the fitted noise changes by between two readings so far apart, nT.
    pub noise_rms_nt: f64,
    /// 95 % interval of the change from both, nT.
    pub interval_nt: [f64; 2],
    /// Whether the span is longer than the recording.
    pub extrapolated: bool,
}

/// Two explanations of a slow change with their probabilities; the odds against a drift before the readings are those
/// against any other name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct DriftExplanations {
    /// Probability of a straight drift beside noise.
    pub drift: f64,
    /// Probability of noise with memory and no drift.
    pub noise_alone: f64,
    /// The drift if it is one, over all forms of the noise, nT/day.
    pub straight_nt_per_day: Quantity,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The mean of a difference over a window.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WindowMean {
    /// Its middle, s.
    pub time_s: f64,
    /// nT, about the mean of all; its uncertainty is that of a mean of the noise over the window, and of the
    /// matrix.
    pub mean_nt: Quantity,
}

/// A housekeeping column that the difference of two magnetometers follows, along one axis: d has c (x − x₀), x
/// the column through a lag of first order, τ dx/dt = column − x.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Followed {
    /// Its name.
    pub column: String,
    /// τ, s; absent where the difference follows at once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lag_s: Option<Quantity>,
    /// Samples by which the column is logged late; below zero where it is logged early.
    #[serde(skip_serializing_if = "is_zero")]
    pub late_rows: i32,
    /// c, nT for each unit of the column.
    pub nt_per_unit: Quantity,
    /// c₂ of a further c₂ (x − x₀)², nT for each unit of the column squared; absent where it follows straight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nt_per_unit2: Option<Quantity>,
    /// Of a part that relaxes eight times as fast, nT for each unit of the column; absent where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fast_nt_per_unit: Option<Quantity>,
    /// The exponent of the column, x being that power of it; absent where it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exponent: Option<f64>,
    /// x₀, the mean of x over the recording: what is left of d there is in the offset.
    pub at: f64,
    /// One over the odds of the readings with the column and without it, as far as these are below one.
    pub p: f64,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

fn is_zero(rows: &i32) -> bool {
    *rows == 0
}
