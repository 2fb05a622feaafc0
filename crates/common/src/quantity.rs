#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de};
use std::fmt;

use crate::{Axis, Extra, PerAxis, number};

/// A 3×3 matrix as JSON writes it: a list of rows.
pub type Matrix3x3 = [[f64; 3]; 3];

/// A value with its standard uncertainty; the unit stands in the key. A bare number has no stated uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged, expecting = "a number or {\"value\": number, \"std\": number that is not negative}")]
pub enum Quantity {
    /// `41234.5`
    Bare(f64),
    /// `{"value": 41234.5, "std": 0.3}`
    Stated {
        /// The estimate.
        value: f64,
        /// Its standard uncertainty (one sigma), in the same unit.
        #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
        #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
        std: Option<f64>,
        /// Factor from the standard uncertainty to a 95 % interval, where a program has estimated the value.
        #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
        #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
        coverage_factor_95: Option<f64>,
        /// Keys that this version does not know.
        #[serde(flatten)]
        extra: Extra,
    },
}

impl Default for Quantity {
    fn default() -> Self {
        Quantity::Bare(0.0)
    }
}

impl Quantity {
    /// A value with a standard uncertainty.
    pub fn new(value: f64, std: f64) -> Self {
        Quantity::Stated { value, std: Some(std), coverage_factor_95: None, extra: Extra::new() }
    }

    /// The same with the factor from its standard uncertainty to a 95 % interval.
    #[must_use]
    pub fn covered_by(self, factor: f64) -> Self {
        match self {
            Quantity::Bare(_) => self,
            Quantity::Stated { value, std, extra, .. } => {
                Quantity::Stated { value, std, coverage_factor_95: Some(factor), extra }
            }
        }
    }

    /// Factor from the standard uncertainty to a 95 % interval, where it is stated.
    pub fn coverage_factor_95(&self) -> Option<f64> {
        match self {
            Quantity::Bare(_) => None,
            Quantity::Stated { coverage_factor_95, .. } => *coverage_factor_95,
        }
    }

    /// The estimate.
    pub fn value(&self) -> f64 {
        match self {
            Quantity::Bare(value) | Quantity::Stated { value, .. } => *value,
        }
    }

    /// The standard uncertainty, where one is stated.
    pub fn std(&self) -> Option<f64> {
        match self {
            Quantity::Bare(_) => None,
            Quantity::Stated { std, .. } => *std,
        }
    }

    /// Standard uncertainty over the size of the value, where one is stated that is more than rounding.
    pub fn relative_std(&self) -> Option<f64> {
        self.std().map(|std| std / self.value().abs()).filter(|relative| *relative > 1e-14)
    }
}

/// As people read it: `0.3085 ± 0.0043`, with `{:+}` `+0.3085 ± 0.0043`; without an uncertainty, or with one of zero, the value alone.
impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self.std() {
            None | Some(0.0) => number::bare(self.value()),
            Some(std) => number::uncertain(self.value(), std),
        };
        f.write_str(&if f.sign_plus() { number::signed(&text) } else { text })
    }
}

/// One number for all three axes, or one for each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged, expecting = "a number, or an object with one number for each of x, y, z")]
pub enum OneOrEach {
    /// The same for all.
    One(f64),
    /// One for each axis.
    Each(PerAxis<f64>),
}

impl OneOrEach {
    /// The number that holds for `axis`.
    pub fn get(&self, axis: Axis) -> Option<f64> {
        match self {
            OneOrEach::One(value) => Some(*value),
            OneOrEach::Each(each) => each.get(axis).copied(),
        }
    }
}

/// Reads a number that may be absent but not negative.
pub(crate) fn not_negative<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    match Option::<f64>::deserialize(deserializer)? {
        Some(value) if value < 0.0 => {
            Err(de::Error::invalid_value(de::Unexpected::Float(value), &"a number that is not negative"))
        }
        value => Ok(value),
    }
}

#[cfg(test)]
mod tests {
    use super::Quantity;

    #[test]
    fn as_people_read_them() {
        let stated = Quantity::new(0.30851, 0.00432);
        assert_eq!(
            (stated.to_string(), format!("{stated:+}")),
            ("0.3085 ± 0.0043".into(), "+0.3085 ± 0.0043".into())
        );
        assert_eq!(
            (Quantity::Bare(-2.5).to_string(), Quantity::new(2.5, 0.0).to_string()),
            ("−2.5".into(), "2.5".into())
        );
    }
}
