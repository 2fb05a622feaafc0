//! Reading a result in which `null` stands for a number: NaN, whatever type holds it.
//!
//! The types of a document are many, and serde compiles the code of each anew for every deserializer. So this one
//! has no layers: it keeps the path of an error itself, and a list is only offered where one is asked for.

use serde::de::value::StrDeserializer;
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Unexpected, Visitor,
};
use serde::{Deserialize, forward_to_deserialize_any};
use serde_json::Value;
use serde_json::value::RawValue;
use std::any::type_name;
use std::cell::RefCell;
use std::vec;

use crate::{OneOrEach, Quantity, parse};

type Outcome<T> = Result<T, serde_json::Error>;

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
    let path = Path::default();
    T::deserialize(Nulls { value, listed: false, path: &path })
        .map_err(|error| parse::explain(text, &path.in_words(), &error))
}

/// Where an error is: its keys and indices, the innermost first, put here as the error passes them.
#[derive(Default)]
struct Path(RefCell<Vec<String>>);

impl Path {
    fn through<T>(&self, outcome: Outcome<T>, segment: impl FnOnce() -> String) -> Outcome<T> {
        if outcome.is_err() {
            self.0.borrow_mut().push(segment());
        }
        outcome
    }

    fn in_words(&self) -> String {
        let path: String = self.0.borrow().iter().rev().map(String::as_str).collect();
        if path.is_empty() { ".".into() } else { path.trim_start_matches('.').into() }
    }
}

/// JSON that reads `null` as a number where one is asked for.
struct Nulls<'p> {
    value: Value,
    /// An item of a list, where `null` keeps the place of what is absent.
    listed: bool,
    path: &'p Path,
}

impl<'de> Nulls<'_> {
    /// What is neither a list nor an object.
    fn single<V: Visitor<'de>>(self, visitor: V) -> Outcome<V::Value> {
        match self.value {
            Value::Null => visitor.visit_unit(),
            Value::Bool(value) => visitor.visit_bool(value),
            Value::Number(number) => number.deserialize_any(visitor),
            Value::String(text) => visitor.visit_string(text),
            Value::Array(_) => Err(Error::invalid_type(Unexpected::Seq, &visitor)),
            Value::Object(_) => Err(Error::invalid_type(Unexpected::Map, &visitor)),
        }
    }
}

impl<'de> Deserializer<'de> for Nulls<'_> {
    type Error = serde_json::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Outcome<V::Value> {
        match self.value {
            Value::Array(_) => self.deserialize_seq(visitor),
            Value::Object(_) => self.deserialize_map(visitor),
            _ => self.single(visitor),
        }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Outcome<V::Value> {
        let Value::Array(items) = self.value else { return self.single(visitor) };
        let mut items = Items { items: items.into_iter(), read: 0, path: self.path };
        let value = visitor.visit_seq(&mut items)?;
        items.end().map(|()| value)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _: usize, visitor: V) -> Outcome<V::Value> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Outcome<V::Value> {
        let Value::Object(entries) = self.value else { return self.single(visitor) };
        visitor.visit_map(Entries { entries: entries.into_iter(), value: None, path: self.path })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Outcome<V::Value> {
        self.deserialize_map(visitor)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Outcome<V::Value> {
        if self.value.is_null() { visitor.visit_f64(f64::NAN) } else { self.single(visitor) }
    }

    /// A number that may be absent is not, where `null` stands for it.
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Outcome<V::Value> {
        let numbers =
            [type_name::<Option<f64>>(), type_name::<Option<Quantity>>(), type_name::<Option<OneOrEach>>()];
        if self.value.is_null() && (self.listed || !numbers.contains(&type_name::<V::Value>())) {
            return visitor.visit_none();
        }
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Outcome<V::Value> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Outcome<V::Value> {
        self.value.deserialize_enum(name, variants, visitor)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 char str string bytes byte_buf unit unit_struct tuple_struct
        identifier ignored_any
    }
}

/// The items of a list.
struct Items<'p> {
    items: vec::IntoIter<Value>,
    read: usize,
    path: &'p Path,
}

impl Items<'_> {
    /// Every item was read.
    fn end(self) -> Outcome<()> {
        let (read, left) = (self.read, self.items.len());
        if left == 0 {
            return Ok(());
        }
        let items = if read == 1 { "element" } else { "elements" };
        Err(Error::invalid_length(read + left, &format!("{read} {items} in sequence").as_str()))
    }
}

impl<'de> SeqAccess<'de> for Items<'_> {
    type Error = serde_json::Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Outcome<Option<S::Value>> {
        let Some(value) = self.items.next() else { return Ok(None) };
        let index = self.read;
        self.read += 1;
        let item = seed.deserialize(Nulls { value, listed: true, path: self.path });
        self.path.through(item.map(Some), || format!("[{index}]"))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.items.len())
    }
}

/// The entries of an object.
struct Entries<'p> {
    entries: serde_json::map::IntoIter,
    /// The key and the value of which the key was read.
    value: Option<(String, Value)>,
    path: &'p Path,
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = serde_json::Error;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Outcome<Option<S::Value>> {
        let Some((key, value)) = self.entries.next() else { return Ok(None) };
        let read = seed.deserialize(StrDeserializer::new(&key));
        let read = self.path.through(read.map(Some), || format!(".{key}"));
        self.value = Some((key, value));
        read
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Outcome<S::Value> {
        let (key, value) = self.value.take().expect("a key before its value");
        let value = seed.deserialize(Nulls { value, listed: false, path: self.path });
        self.path.through(value, || format!(".{key}"))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.entries.len())
    }
}
