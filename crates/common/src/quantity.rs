use serde::{Deserialize, Deserializer, Serialize, de};
use std::fmt;

use crate::{Axis, Extra, PerAxis, number};

/// A 3×3 matrix as JSON writes it: a list of rows.
pub type Matrix3x3 = [[f64; 3]; 3];

/// A value with its standard uncertainty; the unit stands in the key. A bare number has no stated
/// uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "a number or {\"value\": number, \"std\": number that is not negative}")]
pub enum Quantity {
    /// `41234.5`
    Bare(#[serde(deserialize_with = "number_or_null")] f64),
    /// `{"value": 41234.5, "std": 0.3}`
    Stated {
        /// The estimate.
        #[serde(deserialize_with = "number_or_null")]
        value: f64,
        /// Its standard uncertainty (one sigma), in the same unit.
        #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "spread_or_null")]
        #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
        std: Option<f64>,
        /// Factor from the standard uncertainty to a 95 % interval, where a program has estimated the value.
        #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "spread_or_null")]
        #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
        coverage_factor_95: Option<f64>,
        /// The 95 % interval, where it is not as far to either side: of time constants and levels that are
        /// known roughly.
        #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "ends_or_null")]
        interval_95: Option<[f64; 2]>,
        /// Whether the standard uncertainty is a lower bound: intervals made of it hold less often than they
        /// say.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        at_least: bool,
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
        Quantity::Stated {
            value,
            std: Some(std),
            coverage_factor_95: None,
            interval_95: None,
            at_least: false,
            extra: Extra::new(),
        }
    }

    /// The same with the factor from its standard uncertainty to a 95 % interval.
    #[must_use]
    pub fn covered_by(mut self, factor: f64) -> Self {
        if let Quantity::Stated { coverage_factor_95, .. } = &mut self {
            *coverage_factor_95 = Some(factor);
        }
        self
    }

    /// The same with its 95 % interval.
    #[must_use]
    pub fn within(mut self, interval: [f64; 2]) -> Self {
        if let Quantity::Stated { interval_95, .. } = &mut self {
            *interval_95 = Some(interval);
        }
        self
    }

    /// The same with an uncertainty that is a lower bound.
    #[must_use]
    pub fn at_least(mut self) -> Self {
        if let Quantity::Stated { at_least, .. } = &mut self {
            *at_least = true;
        }
        self
    }

    /// Whether the standard uncertainty is a lower bound.
    pub fn is_at_least(&self) -> bool {
        matches!(self, Quantity::Stated { at_least: true, .. })
    }

    /// The 95 % interval, where it is stated or follows from the coverage factor.
    pub fn interval_95(&self) -> Option<[f64; 2]> {
        match self {
            Quantity::Stated { interval_95: Some(interval), .. } => Some(*interval),
            _ => self
                .std()
                .zip(self.coverage_factor_95())
                .map(|(std, factor)| [self.value() - factor * std, self.value() + factor * std]),
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

/// As people read it: `0.3085 ± 0.0043`, with `{:+}` `+0.3085 ± 0.0043`; without an uncertainty, or with one
/// of zero, the value alone; one that is a lower bound as `0.3085 ± 0.0043 (at least)`.
impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = match self.std() {
            None | Some(0.0) => number::bare(self.value()),
            Some(std) => number::uncertain(self.value(), std),
        };
        f.write_str(&if f.sign_plus() { number::signed(&text) } else { text })?;
        if self.is_at_least() { f.write_str(" (at least)") } else { Ok(()) }
    }
}

/// One number for all three axes, or one for each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "a number, or an object with one number for each of x, y, z")]
pub enum OneOrEach {
    /// The same for all.
    One(#[serde(deserialize_with = "number_or_null")] f64),
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

/// Reads a number that is undetermined where it is `null`.
fn number_or_null<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// The same of one that is not negative.
fn spread_or_null<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    Ok(not_negative(deserializer)?.or(Some(f64::NAN)))
}

/// The same of the ends of an interval.
fn ends_or_null<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[f64; 2]>, D::Error> {
    let ends = Option::<[Option<f64>; 2]>::deserialize(deserializer)?;
    Ok(ends.map(|ends| ends.map(|end| end.unwrap_or(f64::NAN))))
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
        assert_eq!(stated.at_least().to_string(), "0.3085 ± 0.0043 (at least)");
        assert_eq!(Quantity::new(2.5, f64::NAN).to_string(), "2.5, uncertainty undetermined");
        assert_eq!(
            (Quantity::Bare(-2.5).to_string(), Quantity::new(2.5, 0.0).to_string()),
            ("−2.5".into(), "2.5".into())
        );
    }
}
