//! JSON text into types: what is wrong is told by path and line, in the words of JSON.

use serde::Deserialize;
use serde::de::{self, DeserializeOwned};
use serde_json::Value;
use std::collections::HashMap;

use crate::Error;

/// The format version that this library reads and writes.
pub const FORMAT_VERSION: u64 = 1;

/// Text without the byte order mark that some editors put before it.
fn unmarked(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

/// Reads any JSON of fluxcal's formats, all of which state their version as `fluxcal`.
pub fn parse<T: DeserializeOwned + Versioned>(text: &str) -> Result<T, Error> {
    let text = unmarked(text);
    if text.trim().is_empty() {
        return Err(Error::Syntax {
            message: "nothing arrived; expected a JSON document. If this program stands in a pipe, \
                      the one before it failed: read its message, or give a file"
                .into(),
        });
    }
    let read = at_path::<T>(text);
    if read.as_ref().ok().and_then(T::format_version) != Some(FORMAT_VERSION) {
        check_version(text)?;
    }
    read
}

/// JSON of fluxcal's formats.
pub trait Versioned {
    /// The format version that it states.
    fn format_version(&self) -> Option<u64>;
}

impl Versioned for Value {
    fn format_version(&self) -> Option<u64> {
        self.get("fluxcal")?.as_u64()
    }
}

/// Reads JSON, or a part of it; an error names the path.
///
/// # Errors
///
/// What is no JSON, with line and column; what is not of the type, with its path, what was found and what was
/// expected.
pub fn at_path<T: DeserializeOwned>(text: &str) -> Result<T, Error> {
    let text = unmarked(text);
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let value = serde_path_to_error::deserialize(&mut deserializer)
        .map_err(|error| explain(text, &error.path().to_string(), error.inner()))?;
    deserializer.end().map_err(|error| explain(text, ".", &error))?;
    Ok(value)
}

/// The version is looked at first, so that a newer document is not blamed for keys that changed.
fn check_version(text: &str) -> Result<(), Error> {
    #[derive(Deserialize)]
    #[serde(expecting = "an object")]
    struct Head {
        fluxcal: Option<Value>,
    }
    let head: Head = serde_json::from_str(text).map_err(|error| explain(text, ".", &error))?;
    let (found, expected) = match head.fluxcal {
        Some(Value::Number(version)) if version.as_u64() == Some(FORMAT_VERSION) => return Ok(()),
        Some(Value::Number(version)) if version.as_f64() > Some(FORMAT_VERSION as f64) => (
            format!("format version {version}"),
            format!("version {FORMAT_VERSION}, the newest that this program knows; install a newer fluxcal"),
        ),
        Some(other) => (other.to_string(), format!("the format version, {FORMAT_VERSION}")),
        None => (
            "no such key".into(),
            format!(
                "\"fluxcal\": {FORMAT_VERSION} at the top of every document; is this a fluxcal document?"
            ),
        ),
    };
    Err(Error::document("fluxcal", found, expected))
}

/// Between path, found and expected of an error that goes through serde, which knows only text.
const CARRIED: char = '\u{1f}';

/// An error of a part that was read by itself, for the one who reads the whole; [`explain`] takes it apart
/// again.
pub(crate) fn carried<E: de::Error>(error: Error) -> E {
    match error {
        Error::Document { path, found, expected } => {
            E::custom(format!("{path}{CARRIED}{found}{CARRIED}{expected}"))
        }
        error => E::custom(error),
    }
}

/// serde's error as a sentence with its path.
pub(crate) fn explain(source: &str, path: &str, error: &serde_json::Error) -> Error {
    let text = error.to_string();
    let (line, column) = (error.line(), error.column());
    let message = text.split(" at line ").next().unwrap_or(&text).to_string();
    if error.is_eof() {
        return Error::Syntax {
            message: format!(
                "the JSON breaks off at line {line}, column {column} ({message}); expected the document's \
                 closing bracket. It was cut: write it again, or look why the program before ended early"
            ),
        };
    }
    if error.is_syntax() {
        return Error::Syntax {
            message: format!(
                "line {line}, column {column}: not JSON ({message}); expected one JSON document"
            ),
        };
    }
    if let [inner, found, expected] = message.split(CARRIED).collect::<Vec<_>>()[..] {
        return Error::document(inner, found, expected).below(path);
    }
    let stands = value_at(source, path).map_or("something else".into(), shortened);
    let path = if path == "." { "the document".to_string() } else { path.to_string() };
    if let Some(key) = message.strip_prefix("missing field `").and_then(|rest| rest.strip_suffix('`')) {
        return Error::document(path, format!("no key `{key}`"), format!("`{key}`, which is required there"));
    }
    if let Some(rest) = message.strip_prefix("duplicate field ") {
        return Error::document(path, format!("the key {rest} twice"), "each key once");
    }
    if message.starts_with("invalid length ") {
        let expected = message.split_once(", expected ").map_or("", |(_, expected)| expected);
        return Error::document(path, "a list", in_words(expected));
    }
    match message.split_once(", expected ") {
        Some((found, expected)) => Error::document(path, found_in_words(found), in_words(expected)),
        // Of a choice of forms, serde says only what was expected.
        None => Error::document(path, stands, message),
    }
}

/// The beginning of a value, as an error repeats it.
fn shortened(value: &str) -> String {
    const SHOWN: usize = 40;
    let line = value.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line,
    }
}

/// What serde found in the words of JSON.
fn found_in_words(found: &str) -> String {
    let kinds = ["invalid type: ", "invalid value: "];
    let found = kinds.iter().find_map(|kind| found.strip_prefix(kind)).unwrap_or(found);
    for (known, word) in [("unknown field ", "the unknown key "), ("unknown variant ", "")] {
        if let Some(name) = found.strip_prefix(known) {
            return format!("{word}{}", name.replace('`', "\""));
        }
    }
    for kind in ["string ", "integer ", "floating point ", "boolean "] {
        if let Some(value) = found.strip_prefix(kind) {
            return value.trim_matches('`').into();
        }
    }
    match found {
        "sequence" => "a list".into(),
        "map" => "an object".into(),
        _ => found.into(),
    }
}

/// serde's names of Rust types in the words of JSON.
fn in_words(expected: &str) -> String {
    match expected {
        "f64" => "a number".into(),
        "i8" => "a whole number from -128 to 127".into(),
        "u32" | "u64" | "usize" => "a whole number, not negative".into(),
        "a nonzero usize" => "a whole number from 1".into(),
        "a boolean" => "true or false".into(),
        "a character" => "a single character".into(),
        "a sequence" => "a list".into(),
        "a map" => "an object".into(),
        _ if expected.starts_with("struct ") => "an object".into(),
        _ if expected.starts_with("an array of length ") => {
            format!("a list of {}", expected.trim_start_matches("an array of length "))
        }
        _ => expected.replace('`', "\""),
    }
}

/// The line, from 1, on which the value at `path` begins in `text`; None where the path leads nowhere.
pub fn line_of(text: &str, path: &str) -> Option<usize> {
    let offset = value_at(text, path)?.as_ptr() as usize - text.as_ptr() as usize;
    Some(text[..offset].matches('\n').count() + 1)
}

/// The value at a path, or the innermost one on the way to it that is there.
fn value_at<'a>(text: &'a str, path: &str) -> Option<&'a str> {
    let mut rest: &serde_json::value::RawValue = serde_json::from_str(unmarked(text)).ok()?;
    for segment in path.split(['.', '[']).filter(|segment| !segment.is_empty()) {
        let next = match segment.strip_suffix(']') {
            Some(index) => {
                let list: Vec<&serde_json::value::RawValue> = serde_json::from_str(rest.get()).ok()?;
                list.get(index.parse::<usize>().ok()?).copied()
            }
            None => {
                let object: HashMap<String, &serde_json::value::RawValue> =
                    serde_json::from_str(rest.get()).ok()?;
                object.get(segment).copied()
            }
        };
        match next {
            Some(value) => rest = value,
            None => break,
        }
    }
    Some(rest.get())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_found_by_path() {
        let text = "{\n \"recordings\": [\n  {\"id\": 1},\n  {\n   \"id\": 2}]}";
        assert_eq!(line_of(text, "recordings[1].id"), Some(5));
        assert_eq!(line_of(text, "recordings[0]"), Some(3));
        assert_eq!(line_of(text, "recordings[0].absent"), Some(3));
    }
}
