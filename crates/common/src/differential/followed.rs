#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Extra, Quantity};

/// A housekeeping column that the difference of two magnetometers follows, along one axis: d has c (x − x₀), x
/// the column through a lag of first order, τ dx/dt = column − x.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
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
