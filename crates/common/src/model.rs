use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{Axis, Extra, Quantity};

/// Physics adopted beyond the basic model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Model {
    /// The effects that `simulate` and `correct` apply.
    #[serde(default)]
    pub effects: Vec<AdoptedEffect>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// One effect of the catalogue with the values of its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AdoptedEffect {
    /// The catalogue's name.
    pub effect: String,
    /// The sensor that it acts on, for an effect of one sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor: Option<Axis>,
    /// The coil that it acts on, for an effect of one coil.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coil: Option<Axis>,
    /// The housekeeping column that it follows, for an effect that does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// The recording in which it acts, by its id; absent: all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// From when on it acts, s on the campaign's clock; absent: from the beginning.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_s: Option<f64>,
    /// Until when it acts, this moment left out, s on the campaign's clock; absent: to the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to_s: Option<f64>,
    /// Its parameters; the unit stands in the key.
    #[serde(default)]
    pub parameters: IndexMap<String, Quantity>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}
