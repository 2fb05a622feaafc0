#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Extra, Quantity};

/// A housekeeping column that the difference of two magnetometers follows along one axis: d has c (x − x₀), x
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
    /// c, nT for each unit of the column.
    pub nt_per_unit: Quantity,
    /// x₀, the mean of x over the recording: what is left of d there is in the offset.
    pub at: f64,
    /// Probability that noise alone follows one of the columns, at one of the lags, as closely; where the
    /// column stands in the place of a straight drift, how likely the readings are with that over how likely
    /// they are with it, times what was tried.
    pub p: f64,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}
