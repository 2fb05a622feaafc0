//! Reading a result in which `null` stands for a number: NaN, whatever type holds it.

use serde::de::value::{MapDeserializer, SeqDeserializer};
use serde::de::{DeserializeOwned, Deserializer, IntoDeserializer, Visitor};
use serde::{Deserialize, forward_to_deserialize_any};
use serde_json::Value;
use serde_json::value::RawValue;
use std::any::type_name;

use crate::{OneOrEach, Quantity, parse};

/// A part of a document, for `deserialize_with`: it is read by itself, so that the code of its types is made
/// once.
///
/// # Errors
///
/// As of a document, below the path at which the part stands.
pub fn read<'de, D: Deserializer<'de>, T: DeserializeOwned>(deserializer: D) -> Result<T, D::Error> {
    let text = <Box<RawValue>>::deserialize(deserializer)?;
    part(text.get()).map_err(parse::carried)
}

/// The same of its text.
pub fn part<T: DeserializeOwned>(text: &str) -> Result<T, crate::Error> {
    let value = serde_json::from_str(text).map_err(|error| parse::explain(text, ".", &error))?;
    serde_path_to_error::deserialize(Nulls { value, listed: false })
        .map_err(|error| parse::explain(text, &error.path().to_string(), error.inner()))
}

/// JSON that reads `null` as a number where one is asked for.
struct Nulls {
    value: Value,
    /// An item of a list, where `null` keeps the place of what is absent.
    listed: bool,
}

impl<'de> Deserializer<'de> for Nulls {
    type Error = serde_json::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        match self.value {
            Value::Array(items) => {
                let items = items.into_iter().map(|value| Nulls { value, listed: true });
                SeqDeserializer::new(items).deserialize_any(visitor)
            }
            Value::Object(entries) => {
                let entries = entries.into_iter().map(|(key, value)| (key, Nulls { value, listed: false }));
                MapDeserializer::new(entries).deserialize_any(visitor)
            }
            other => other.deserialize_any(visitor),
        }
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        if self.value.is_null() { visitor.visit_f64(f64::NAN) } else { self.deserialize_any(visitor) }
    }

    /// A number that may be absent is not, where `null` stands for it.
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Self::Error> {
        let numbers =
            [type_name::<Option<f64>>(), type_name::<Option<Quantity>>(), type_name::<Option<OneOrEach>>()];
        if self.value.is_null() && (self.listed || !numbers.contains(&type_name::<V::Value>())) {
            return visitor.visit_none();
        }
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Self::Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Self::Error> {
        self.value.deserialize_enum(name, variants, visitor)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map struct identifier ignored_any
    }
}

impl IntoDeserializer<'_, serde_json::Error> for Nulls {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}
