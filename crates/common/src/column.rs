//! A column of readings.

#[cfg(feature = "schema")]
use schemars::{JsonSchema, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de, ser::SerializeSeq};
use std::fmt;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// A column of readings; a missing one (`null`) is NaN in memory, and nothing else is. Clones share their readings until one of them is changed:
/// a month of readings once a second is 20 MB a column.
#[derive(Clone, Debug, Default)]
pub struct Column(Arc<Vec<f64>>);

impl Deref for Column {
    type Target = Vec<f64>;

    fn deref(&self) -> &Vec<f64> {
        &self.0
    }
}

impl DerefMut for Column {
    fn deref_mut(&mut self) -> &mut Vec<f64> {
        Arc::make_mut(&mut self.0)
    }
}

impl AsRef<[f64]> for Column {
    fn as_ref(&self) -> &[f64] {
        &self.0
    }
}

impl PartialEq for Column {
    fn eq(&self, other: &Self) -> bool {
        self.len() == other.len()
            && self.iter().zip(other.iter()).all(|(a, b)| a == b || (a.is_nan() && b.is_nan()))
    }
}

impl From<Vec<f64>> for Column {
    fn from(values: Vec<f64>) -> Self {
        Column(Arc::new(values))
    }
}

impl From<Column> for Vec<f64> {
    fn from(column: Column) -> Self {
        Arc::unwrap_or_clone(column.0)
    }
}

impl<'a> IntoIterator for &'a Column {
    type Item = &'a f64;
    type IntoIter = std::slice::Iter<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl FromIterator<f64> for Column {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        Vec::from_iter(values).into()
    }
}

impl Serialize for Column {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.len()))?;
        for value in self.iter() {
            list.serialize_element(&value.is_finite().then_some(*value))?;
        }
        list.end()
    }
}

impl<'de> Deserialize<'de> for Column {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let readings = Vec::<Reading>::deserialize(deserializer)?;
        let mut readings: Vec<f64> = readings.into_iter().map(|reading| reading.0).collect();
        readings.shrink_to_fit();
        Ok(readings.into())
    }
}

/// One number or null, with an error that says so.
struct Reading(f64);

impl<'de> Deserialize<'de> for Reading {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor;
        impl de::Visitor<'_> for Visitor {
            type Value = Reading;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, or null where the reading is missing")
            }
            fn visit_f64<E>(self, value: f64) -> Result<Reading, E> {
                Ok(Reading(value))
            }
            fn visit_i64<E>(self, value: i64) -> Result<Reading, E> {
                Ok(Reading(value as f64))
            }
            fn visit_u64<E>(self, value: u64) -> Result<Reading, E> {
                Ok(Reading(value as f64))
            }
            fn visit_unit<E>(self) -> Result<Reading, E> {
                Ok(Reading(f64::NAN))
            }
        }
        deserializer.deserialize_any(Visitor)
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Column {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Column".into()
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        json_schema!({
            "description": "A column of readings; null = missing reading.",
            "type": "array",
            "items": { "type": ["number", "null"] }
        })
    }
}
