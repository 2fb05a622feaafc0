//! A JSON object a line, as a mapping describes them.

use serde_json::{Map, Value};
use tables::Place;

use crate::Error;
use crate::mapping::{Mapping, SourceColumn};
use crate::parts::{Room, in_parts};
use crate::piece::Piece;
use crate::text::{Source, lines_from, quoted};
use crate::times::Times;

/// Reads a file. Errors: a line that is no JSON object, a value that is no number, a time that is none, each
/// with line and key; a key of the mapping that no line has.
pub fn read(source: &Source, mapping: &Mapping) -> Result<Piece, Error> {
    let times = Times::new(source, mapping.time.as_ref(), '.')?;
    let missing = mapping.missing.iter().filter_map(|text| text.parse().ok()).collect();
    let parser = Parser { source, mapping, times: &times, missing };
    let rows = in_parts(&source.bytes, 1, mapping.columns.len(), 2, |part, first_line, room| {
        let mut rows = lines_from(part, first_line).filter(|(_, line)| !line.trim_ascii().is_empty());
        rows.try_for_each(|(number, line)| parser.row(line, number, room))
    })?;
    for (column, values) in mapping.columns.iter().zip(&rows.columns) {
        let key = column.from.name();
        let is_there =
            || memchr::memmem::find(&source.bytes, Value::from(key).to_string().as_bytes()).is_some();
        if !values.is_empty() && values.iter().all(|value| value.is_nan()) && !is_there() {
            let expected = "it in one at least; look at `from` in the mapping";
            return Err(source.fault(Place::Whole, format!("no line with the key {key:?}"), expected));
        }
    }
    Piece::mapped(source, "NDJSON", mapping, &times, rows)
}

struct Parser<'a> {
    source: &'a Source,
    mapping: &'a Mapping,
    times: &'a Times,
    missing: Vec<f64>,
}

impl Parser<'_> {
    fn row(&self, line: &[u8], number: u32, room: &mut Room) -> Result<(), Error> {
        self.source.check_length(number, line)?;
        let refused = |key: (usize, &str), found: String, expected: &str| {
            Err(self.source.in_field(number, key, found, expected))
        };
        let object: Map<String, Value> = serde_json::from_slice(line).map_err(|error| {
            let (found, more) = match error.is_eof() {
                true => {
                    (format!("an object that breaks off at byte {}", error.column()), "; was the file cut?")
                }
                false => (format!("{} ({error})", quoted(line)), ""),
            };
            self.source.in_line(number, found, format!("one JSON object on each line{more}"))
        })?;
        for (index, column) in self.mapping.columns.iter().enumerate() {
            let key = column.from.name();
            let value = match object.get(key) {
                None | Some(Value::Null) => f64::NAN,
                Some(Value::Number(value)) => {
                    let value = value.as_f64().unwrap_or(f64::NAN);
                    if self.missing.contains(&value) { f64::NAN } else { value }
                }
                Some(Value::String(text)) if self.mapping.missing.contains(text) || text == "nan" => f64::NAN,
                Some(other) => {
                    return refused(
                        (index + 1, key),
                        quoted(other.to_string().as_bytes()),
                        "a number, or null",
                    );
                }
            };
            room.set(index, value);
        }
        if self.times.are_counted() {
            room.end_row(0, number);
            return Ok(());
        }
        let mut keys =
            self.mapping.time.iter().flat_map(|time| &time.columns).map(SourceColumn::name).peekable();
        let first = keys.peek().copied().unwrap_or_default();
        let mut text = String::new();
        for key in keys {
            match object.get(key) {
                Some(Value::String(part)) => text.push_str(part),
                Some(Value::Number(part)) => text.push_str(&part.to_string()),
                other => {
                    let found =
                        other.map_or("no such key".to_string(), |value| quoted(value.to_string().as_bytes()));
                    return refused((1, key), found, &self.times.expected());
                }
            }
            text.push(' ');
        }
        let text = text.trim();
        match self.times.read(text.as_bytes()) {
            Ok(time) => room.end_row(time, number),
            Err(expected) => return refused((1, first), quoted(text.as_bytes()), &expected),
        }
        Ok(())
    }
}
