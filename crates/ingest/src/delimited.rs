//! Lines of values between separators, as a mapping describes them.

mod fields;
mod parser;

use common::number::counted;
use tables::{COLUMN_LIMIT, Place, listed};

use crate::Error;
use crate::mapping::{Mapping, SourceColumn};
use crate::parts::{Room, in_parts};
use crate::piece::Piece;
use crate::text::{Source, decoded, lines, split_line};
use crate::times::Times;

pub use fields::fields;
use parser::{Parser, Slot};

/// Reads a file. Errors: a header without a column that the mapping names; with line and column, a value that
/// is no number in the mapping's notation or no time, a row with more or fewer values than the header has
/// names.
pub fn read(source: &Source, mapping: &Mapping) -> Result<Piece, Error> {
    let times = Times::new(source, mapping.time.as_ref(), mapping.decimal)?;
    let (names, first_line, data) = header(source, mapping)?;
    let comment = mapping.comment.as_deref().map(str::as_bytes);
    let is_row = |line: &[u8]| {
        let text = line.trim_ascii_start();
        !text.is_empty() && !comment.is_some_and(|mark| text.starts_with(mark))
    };
    let width = match &names {
        Some(names) => names.len(),
        None => {
            let first = lines(data).find(|(_, line)| is_row(line));
            first.map_or(0, |(_, line)| fields(line, mapping.separator).len())
        }
    };
    if width > COLUMN_LIMIT {
        return Err(too_many(source, mapping.header_line.unwrap_or(1), width));
    }
    let parser = Parser {
        source,
        mapping,
        times: &times,
        slots: slots(source, mapping, names.as_deref(), width)?,
        missing: mapping.missing.iter().filter_map(|text| text.replace(',', ".").parse().ok()).collect(),
        names,
    };
    let parse = |part: &[u8], line: u32, room: &mut Room| parser.parse(part, line, room, &is_row);
    let rows = in_parts(data, first_line, mapping.columns.len(), width, parse)?;
    let mut piece = Piece::mapped(source, "CSV", mapping, &times, rows)?;
    piece.notes.extend(source.latin_1(source.bytes.len() - data.len()));
    if !source.bytes.ends_with(b"\n") {
        let words = "the last line has no end; if the file was cut, its last value may be cut too";
        piece.notes.push(words.into());
    }
    Ok(piece)
}

/// The error for a file of far too many columns.
pub fn too_many(source: &Source, line: u32, width: usize) -> Error {
    let expected = format!(
        "at most {COLUMN_LIMIT}; is the separator right, and is it a table with a row for each time?"
    );
    source.in_line(line, counted(width, "column"), expected)
}

/// Names of the columns where a line has them, the number of the line of the first row, and the text from
/// there.
type Header<'a> = (Option<Vec<String>>, u32, &'a [u8]);

fn header<'a>(source: &'a Source, mapping: &Mapping) -> Result<Header<'a>, Error> {
    let (mut names, mut rest, mut number) = (None, &source.bytes[..], 1);
    let first_row = mapping.first_row_line.unwrap_or(mapping.header_line.map_or(1, |line| line + 1));
    while number < first_row {
        if rest.is_empty() {
            let expected =
                format!("the first row on line {first_row}, as the mapping says; was it copied in full?");
            return Err(source.fault(Place::Whole, counted(number as usize - 1, "line"), expected));
        }
        let (line, after) = split_line(rest);
        if Some(number) == mapping.header_line {
            let mark = mapping.comment.as_deref().unwrap_or_default();
            let line = line.trim_ascii_start().strip_prefix(mark.as_bytes()).unwrap_or(line);
            let fields = fields(line, mapping.separator).into_iter();
            names = Some(fields.map(|name| decoded(name).trim().to_string()).collect());
        }
        rest = after;
        number += 1;
    }
    Ok((names, first_row, rest))
}

fn slots(
    source: &Source,
    mapping: &Mapping,
    names: Option<&[String]>,
    width: usize,
) -> Result<Vec<Slot>, Error> {
    let mut slots = vec![Slot::Skipped; width];
    let times = mapping.time.iter().flat_map(|time| &time.columns);
    let times = times.enumerate().map(|(number, from)| (from, Slot::Time(number)));
    let values =
        mapping.columns.iter().enumerate().map(|(number, column)| (&column.from, Slot::Value(number)));
    for (from, slot) in times.chain(values) {
        let fault = |found: String, expected: &str| {
            Err(source.in_line(mapping.header_line.unwrap_or(1), found, expected))
        };
        let column = match (from, names) {
            (SourceColumn::Number(number), _) if number.get() <= width => number.get() - 1,
            (SourceColumn::Number(number), _) => {
                let expected = format!("column {number}, which the mapping takes");
                return fault(counted(width, "column"), &expected);
            }
            (SourceColumn::Name(name), None) => {
                let expected =
                    format!("`header_line` in the mapping, so that {name:?} can be found, or its number");
                return fault("no names of columns".into(), &expected);
            }
            (SourceColumn::Name(name), Some(names)) => {
                let mut met = (0..width).filter(|column| names[*column] == name.trim());
                match (met.next(), met.next()) {
                    (Some(column), None) => column,
                    (Some(_), Some(_)) => {
                        let expected = "in the mapping, the number of the one that is meant";
                        return fault(format!("two columns {name:?}"), expected);
                    }
                    (None, _) => {
                        let found = format!("no column {name:?} among {}", listed(names, 20));
                        let expected = "the columns that the mapping takes; is its separator right?";
                        return fault(found, expected);
                    }
                }
            }
        };
        if slots[column] != Slot::Skipped {
            return fault(format!("column {} twice", column + 1), "each column once in the mapping");
        }
        slots[column] = slot;
    }
    Ok(slots)
}
