use fast_float2::parse_partial;
use memchr::{memchr, memchr2};
use std::io::Read;

use super::lines::{Chunk, Lines};
use super::reader::Reader;
use super::text::{self, Parse, Parsed, empty_line};
use super::wanted::{check_wish, select};
use crate::error::quoted;
use crate::{Error, Place, fault};

/// What a header must be.
const HEADER: &str = "a line of column names, cut at commas";

/// Reads the header, and the rest ahead.
pub fn open(
    input: impl Read + Send + 'static,
    source_name: &str,
    wanted: Option<&[&str]>,
) -> Result<Reader, Error> {
    check_wish(source_name, wanted)?;
    let mut lines = Lines::new(input, source_name);
    let (line, names) = loop {
        let Some(chunk) = lines.chunk(1)? else {
            return Err(fault(source_name, Place::Whole, "no header", HEADER));
        };
        if !chunk.bytes.starts_with(b"#") {
            break (chunk.first_line, header(source_name, &chunk)?);
        }
    };
    let place = Place::Line(line);
    let all: Vec<_> = names.iter().map(String::as_str).collect();
    let wanted = wanted.unwrap_or(&all);
    let mut slots = vec![None; names.len()];
    for (slot, column) in select(source_name, &names, place, wanted)?.into_iter().enumerate() {
        slots[column] = Some(slot);
    }
    let columns = wanted.iter().map(|name| name.to_string()).collect();
    let parser = Csv { source_name: source_name.into(), columns: wanted.len(), names, slots };
    text::read(lines, columns, parser)
}

fn header(source_name: &str, chunk: &Chunk) -> Result<Vec<String>, Error> {
    let text = chunk.utf8(source_name)?;
    let refused = |found: String| Err(fault(source_name, Place::Line(chunk.first_line), found, HEADER));
    if text.matches('"').count() % 2 == 1 {
        return refused("a quote that is not closed".into());
    }
    let mut reader = ::csv::ReaderBuilder::new()
        .has_headers(false)
        .trim(::csv::Trim::All)
        .from_reader(text.trim_end_matches(['\n', '\r']).as_bytes());
    let Some(Ok(record)) = reader.records().next() else {
        return refused("an empty line".into());
    };
    let names: Vec<String> = record.iter().map(str::to_string).collect();
    if let Some(number) = names.iter().find(|name| name.parse::<f64>().is_ok()) {
        return refused(format!("the number {number}"));
    }
    Ok(names)
}

struct Csv {
    source_name: String,
    /// How many columns are wanted.
    columns: usize,
    /// Of all columns of the file.
    names: Vec<String>,
    /// For each column of the file, which of the wanted it is.
    slots: Vec<Option<usize>>,
}

impl Parse for Csv {
    fn parse(&self, chunk: &Chunk) -> Result<Parsed, Error> {
        let bytes = chunk.utf8(&self.source_name)?.as_bytes();
        let mut columns = vec![Vec::with_capacity(chunk.lines); self.columns];
        let last = self.slots.len() - 1;
        let mut at = 0;
        while at < bytes.len() {
            if matches!(bytes[at..], [b'\n', ..] | [b'\r', b'\n', ..]) {
                break;
            }
            let start = at;
            for (column, slot) in self.slots.iter().enumerate() {
                let end = match slot {
                    Some(slot) => {
                        let (value, end) =
                            value(&bytes[at..]).ok_or_else(|| self.not_a_number(chunk, at, column))?;
                        columns[*slot].push(value);
                        at + end
                    }
                    None => {
                        at + field_end(&bytes[at..]).ok_or_else(|| self.not_a_number(chunk, at, column))?
                    }
                };
                at = match bytes[end..] {
                    [b',', ..] if column < last => end + 1,
                    [b'\n', ..] if column == last => end + 1,
                    [b'\r', b'\n', ..] if column == last => end + 2,
                    [] | [b'\r'] if column == last => bytes.len(),
                    _ => return Err(self.unequal(chunk, start)),
                };
            }
        }
        let ends_at = (at < bytes.len()).then_some(at);
        let empty = ends_at.map(|at| chunk.line_at(at));
        match (ends_at, empty) {
            (Some(at), Some(line)) if bytes[at..].iter().any(|byte| !matches!(byte, b'\n' | b'\r')) => {
                Err(empty_line(&self.source_name, line))
            }
            _ => Ok(Parsed { columns, empty_line: empty, met: vec![true; self.columns] }),
        }
    }
}

impl Csv {
    fn not_a_number(&self, chunk: &Chunk, at: usize, column: usize) -> Error {
        let rest = &chunk.bytes[at..];
        let line = &rest[..memchr(b'\n', rest).unwrap_or(rest.len())];
        let (found, expected) = match field_end(rest) {
            None => (format!("{}, a quote that is not closed on its line", quoted(line)), "a closing quote"),
            Some(end) => (quoted(&rest[..end]), "a finite number, or nothing where one is missing"),
        };
        let place =
            Place::Field { line: chunk.line_at(at), column: column + 1, name: self.names[column].clone() };
        fault(&self.source_name, place, found, expected)
    }

    fn unequal(&self, chunk: &Chunk, start: usize) -> Error {
        let rest = &chunk.bytes[start..];
        let (mut at, mut fields) = (0, 1);
        while let Some(end) = field_end(&rest[at..]) {
            at += end + 1;
            if rest.get(at - 1) != Some(&b',') {
                break;
            }
            fields += 1;
        }
        fault(
            &self.source_name,
            Place::Line(chunk.line_at(start)),
            format!("{fields} value{}", if fields == 1 { "" } else { "s" }),
            format!("{}, one for each name in the header", self.names.len()),
        )
    }
}

/// The number of the field that the text begins with, and where the field ends.
#[inline]
fn value(text: &[u8]) -> Option<(f64, usize)> {
    if matches!(text, [b',' | b'\n', ..] | []) {
        return Some((f64::NAN, 0));
    }
    match parse_partial::<f64, _>(text) {
        Ok((value, end))
            if value.is_finite() && matches!(text[end..], [b',' | b'\n', ..] | [b'\r', b'\n', ..] | []) =>
        {
            Some((value, end))
        }
        _ => odd_value(text),
    }
}

/// As `value`, for numbers between blanks or quotes, and missing ones.
#[cold]
fn odd_value(text: &[u8]) -> Option<(f64, usize)> {
    let end = field_end(text)?;
    let mut field = text[..end].trim_ascii();
    if let [b'"', inner @ .., b'"'] = field {
        field = inner.trim_ascii();
    }
    if field.is_empty() || field == b"null" || field.eq_ignore_ascii_case(b"nan") {
        return Some((f64::NAN, end));
    }
    let value = fast_float2::parse::<f64, _>(field).ok()?;
    value.is_finite().then_some((value, end))
}

/// Where the field that the text begins with ends; none where it has a quote that is not closed on its line.
fn field_end(text: &[u8]) -> Option<usize> {
    let mut at = 0;
    if text.first() == Some(&b'"') {
        at = 1;
        loop {
            at += memchr(b'"', &text[at..])? + 1;
            if text.get(at) != Some(&b'"') {
                break;
            }
            at += 1;
        }
        if text[..at].contains(&b'\n') {
            return None;
        }
    }
    let end = memchr2(b',', b'\n', &text[at..]).map_or(text.len(), |end| at + end);
    let carriage_return = text[..end].ends_with(b"\r") && text.get(end) != Some(&b',');
    Some(end - usize::from(carriage_return))
}
