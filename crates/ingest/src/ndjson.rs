//! A JSON object a line, as a mapping describes them.

use serde_json::{Map, Value};
use tables::{LINE_LIMIT, Place};

use crate::Error;
use crate::mapping::{Mapping, SourceColumn};
use crate::parts::{Room, RowFault, in_parts};
use crate::piece::Piece;
use crate::text::{Source, quoted, split_line};
use crate::times::Times;

/// Reads a file.
///
/// # Errors
///
/// A line that is no JSON object, a value that is no number, a time that is none, each with line and key; a
/// key of the mapping that no line has.
pub fn read(source: &Source, mapping: &Mapping) -> Result<Piece, Error> {
    let times = Times::new(source, mapping.time.as_ref(), '.')?;
    let missing = mapping.missing.iter().filter_map(|text| text.parse().ok()).collect();
    let parser = Parser { mapping, times: &times, missing };
    let rows = in_parts(&source.bytes, 1, mapping.columns.len(), 2, |part, line, room| {
        parser.parse(part, line, room)
    });
    let rows = rows.map_err(|fault| fault.of(source))?;
    for (column, values) in mapping.columns.iter().zip(&rows.columns) {
        let key = column.from.name();
        if !values.is_empty() && values.iter().all(|value| value.is_nan()) && !mentions(&source.bytes, key) {
            let expected = "it in one at least; look at `from` in the mapping";
            return Err(source.fault(Place::Whole, format!("no line with the key {key:?}"), expected));
        }
    }
    Piece::mapped(source, "NDJSON", mapping, &times, rows)
}

fn mentions(bytes: &[u8], key: &str) -> bool {
    memchr::memmem::find(bytes, Value::from(key).to_string().as_bytes()).is_some()
}

struct Parser<'a> {
    mapping: &'a Mapping,
    times: &'a Times,
    missing: Vec<f64>,
}

impl Parser<'_> {
    fn parse(&self, part: &[u8], first_line: u32, room: &mut Room) -> Result<(), RowFault> {
        let (mut rest, mut number) = (part, first_line);
        while !rest.is_empty() {
            let (line, after) = split_line(rest);
            rest = after;
            if !line.trim_ascii().is_empty() {
                self.row(line, number, room)?;
            }
            number += 1;
        }
        Ok(())
    }

    fn row(&self, line: &[u8], number: u32, room: &mut Room) -> Result<(), RowFault> {
        let fault = |column: Option<(usize, String)>, found: String, expected: String| {
            Err(RowFault { line: number, column, found, expected })
        };
        if line.len() > LINE_LIMIT {
            return fault(None, format!("a line of {} bytes", line.len()), "a row of values".into());
        }
        let object: Map<String, Value> = match serde_json::from_slice(line) {
            Ok(object) => object,
            Err(error) if error.is_eof() => {
                let found = format!("an object that breaks off at byte {}", error.column());
                return fault(None, found, "one JSON object on each line; was the file cut?".into());
            }
            Err(error) => {
                let found = format!("{} ({error})", quoted(line));
                return fault(None, found, "one JSON object on each line".into());
            }
        };
        for (index, column) in self.mapping.columns.iter().enumerate() {
            let key = column.from.name();
            let place = || Some((index + 1, key.to_string()));
            let value = match object.get(key) {
                None | Some(Value::Null) => f64::NAN,
                Some(Value::Number(value)) => {
                    let value = value.as_f64().unwrap_or(f64::NAN);
                    if self.missing.contains(&value) { f64::NAN } else { value }
                }
                Some(Value::String(text)) if self.mapping.missing.contains(text) || text == "nan" => f64::NAN,
                Some(other) => {
                    return fault(place(), quoted(other.to_string().as_bytes()), "a number, or null".into());
                }
            };
            room.set(index, value);
        }
        if self.times.are_counted() {
            room.end_row(0, number);
            return Ok(());
        }
        let keys = self.mapping.time.iter().flat_map(|time| &time.columns).map(SourceColumn::name);
        let mut text = String::new();
        for key in keys {
            match object.get(key) {
                Some(Value::String(part)) => text.push_str(part),
                Some(Value::Number(part)) => text.push_str(&part.to_string()),
                other => {
                    let found =
                        other.map_or("no such key".to_string(), |value| quoted(value.to_string().as_bytes()));
                    return fault(Some((1, key.to_string())), found, self.times.expected());
                }
            }
            text.push(' ');
        }
        let text = text.trim();
        match self.times.read(text.as_bytes()) {
            Ok(time) => room.end_row(time, number),
            Err(expected) => {
                let key =
                    self.mapping.time.iter().flat_map(|time| &time.columns).map(SourceColumn::name).next();
                return fault(key.map(|key| (1, key.to_string())), quoted(text.as_bytes()), expected);
            }
        }
        Ok(())
    }
}
