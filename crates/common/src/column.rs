//! A column of readings.

#[cfg(feature = "schema")]
use schemars::{JsonSchema, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use serde_json::value::RawValue;
use std::fmt;
use std::ops::{Deref, DerefMut};
use std::sync::{Arc, OnceLock};

use crate::column_text::{self, Summary};
use crate::range;

/// A column of readings; a missing one (`null`) is NaN in memory, and nothing else is.
///
/// Clones share their readings until one of them is changed: a month of readings once a second is 20 MB a
/// column. A column of a document stays text until its readings are asked for, and is written as that text
/// unless it was changed: stages pass on what they do not use.
#[derive(Clone, Default)]
pub struct Column(Arc<Readings>);

#[derive(Clone, Default)]
struct Readings {
    /// The JSON text of the document, with its summary.
    text: Option<(Box<RawValue>, Summary)>,
    values: OnceLock<Vec<f64>>,
}

impl Readings {
    fn values(&self) -> &Vec<f64> {
        self.values.get_or_init(|| match &self.text {
            Some((text, summary)) => column_text::values(text.get(), summary.rows),
            None => Vec::new(),
        })
    }
}

impl Column {
    /// Number of rows; the text of a column is not read for it.
    pub fn len(&self) -> usize {
        self.0.text.as_ref().map_or_else(|| self.0.values().len(), |(_, summary)| summary.rows)
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The first row whose value is outside a range; a missing reading is not. The text is read only where it
    /// may hold one.
    pub fn first_outside(&self, [low, high]: [f64; 2]) -> Option<usize> {
        let within = |bound: f64| low <= -bound && bound <= high;
        if self.0.text.as_ref().is_some_and(|(_, summary)| within(summary.bound)) {
            return None;
        }
        range::first_outside([low, high], self)
    }
}

impl Deref for Column {
    type Target = Vec<f64>;

    fn deref(&self) -> &Vec<f64> {
        self.0.values()
    }
}

impl DerefMut for Column {
    fn deref_mut(&mut self) -> &mut Vec<f64> {
        if Arc::get_mut(&mut self.0).is_none() {
            *self = Column::from(self.0.values().clone());
        }
        self.0.values();
        let readings = Arc::get_mut(&mut self.0).expect("of this column alone");
        readings.text = None;
        readings.values.get_mut().expect("read above")
    }
}

impl AsRef<[f64]> for Column {
    fn as_ref(&self) -> &[f64] {
        self
    }
}

impl fmt::Debug for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.values().fmt(f)
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
        Column(Arc::new(Readings { text: None, values: values.into() }))
    }
}

impl From<Column> for Vec<f64> {
    fn from(column: Column) -> Self {
        column.0.values();
        Arc::unwrap_or_clone(column.0).values.into_inner().unwrap_or_default()
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
        if let Some((text, _)) = &self.0.text {
            return text.serialize(serializer);
        }
        serializer.collect_seq(self.iter().map(|value| value.is_finite().then_some(*value)))
    }
}

impl<'de> Deserialize<'de> for Column {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Vec::<Reading>::deserialize(deserializer)?.into())
    }
}

impl From<Vec<Reading>> for Column {
    fn from(readings: Vec<Reading>) -> Self {
        let mut values: Vec<f64> = readings.into_iter().map(|reading| reading.0).collect();
        values.shrink_to_fit();
        values.into()
    }
}

/// A column of JSON text, kept as that where it is a plain list.
pub(crate) struct Unread(pub Column);

impl<'de> Deserialize<'de> for Unread {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = <Box<RawValue>>::deserialize(deserializer)?;
        match column_text::summary(text.get()) {
            Some(summary) => {
                let readings = Readings { text: Some((text, summary)), values: OnceLock::new() };
                Ok(Unread(Column(Arc::new(readings))))
            }
            None => crate::parse::at_path::<Vec<Reading>>(text.get())
                .map(|readings| Unread(readings.into()))
                .map_err(crate::parse::carried),
        }
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
