use fast_float2::parse_partial;
use memchr::{memchr, memchr2};
use serde::de::IgnoredAny;
use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Read;

use super::lines::{Chunk, Lines};
use super::reader::Reader;
use super::text::{self, Parse, Parsed, empty_line};
use super::wanted::{check_wish, select};
use crate::error::quoted;
use crate::{Error, Place, fault};

/// What a line must be.
const OBJECT: &str = "one JSON object, {\"name\": number or null, …}";

/// Reads the first line, and the whole ahead.
pub fn open(
    input: impl Read + Send + 'static,
    source_name: &str,
    wanted: Option<&[&str]>,
) -> Result<Reader, Error> {
    check_wish(source_name, wanted)?;
    let mut lines = Lines::new(input, source_name);
    let Some(first) = lines.chunk(1)? else {
        return Err(fault(source_name, Place::Whole, "no line", OBJECT));
    };
    let usual = keys(source_name, &first)?;
    lines.put_back(first);
    let all: Vec<_> = usual.iter().map(String::as_str).collect();
    select(source_name, &usual, Place::Line(1), if wanted.is_some() { &[] } else { &all })?;
    let columns: Vec<String> = wanted.unwrap_or(&all).iter().map(|name| name.to_string()).collect();
    let slots: HashMap<_, _> = columns.iter().cloned().enumerate().map(|(slot, name)| (name, slot)).collect();
    let usual = usual.into_iter().map(|key| (slots.get(&key).copied(), key)).collect();
    let parser = NdJson { source_name: source_name.into(), usual, slots, others: wanted.is_some() };
    text::read(lines, columns, parser)
}

/// The keys of the first line.
fn keys(source_name: &str, first: &Chunk) -> Result<Vec<String>, Error> {
    let line = first.utf8(source_name)?.trim_ascii().as_bytes();
    let mut keys = Vec::new();
    members(line, |key, value| {
        keys.push(key.into_owned());
        after_any(value)
    })
    .map_err(|at| not_an_object(source_name, first.first_line, &line[at..]))?;
    if keys.is_empty() {
        return Err(fault(source_name, Place::Line(first.first_line), "no key", OBJECT));
    }
    Ok(keys)
}

fn not_an_object(source_name: &str, line: u64, rest: &[u8]) -> Error {
    let found = if rest.is_empty() { "the end of the line".into() } else { quoted(rest) };
    fault(source_name, Place::Line(line), found, OBJECT)
}

struct NdJson {
    source_name: String,
    /// Keys of the first line, with the wanted column that each is; other lines probably have the same.
    usual: Vec<(Option<usize>, String)>,
    /// The wanted columns.
    slots: HashMap<String, usize>,
    /// Whether keys other than the wanted are passed over.
    others: bool,
}

impl Parse for NdJson {
    fn parse(&self, chunk: &Chunk) -> Result<Parsed, Error> {
        chunk.utf8(&self.source_name)?;
        let mut columns = vec![Vec::with_capacity(chunk.lines); self.slots.len()];
        let mut met = vec![false; self.slots.len()];
        let mut first_empty = None;
        let mut rest = &chunk.bytes[..];
        let mut number = chunk.first_line;
        let mut rows = 0;
        while !rest.is_empty() {
            let end = memchr(b'\n', rest).unwrap_or(rest.len());
            let line = rest[..end].trim_ascii();
            rest = rest.get(end + 1..).unwrap_or_default();
            match (line.is_empty(), first_empty) {
                (true, _) => first_empty = first_empty.or(Some(number)),
                (false, Some(empty)) => return Err(empty_line(&self.source_name, empty)),
                (false, None) => {
                    self.row(line, number, rows, &mut columns)?;
                    rows += 1;
                    for (column, met) in columns.iter_mut().zip(&mut met) {
                        *met |= column.len() == rows;
                        column.resize(rows, f64::NAN);
                    }
                }
            }
            number += 1;
        }
        Ok(Parsed { columns, empty_line: first_empty, met })
    }
}

impl NdJson {
    /// Appends the numbers of a line to the columns, which have `rows` each.
    fn row(&self, line: &[u8], number: u64, rows: usize, columns: &mut [Vec<f64>]) -> Result<(), Error> {
        let mut usual = self.usual.iter();
        let mut refused = None;
        let mut refuse = |key: &str, found: String, expected: &str| {
            let place = Place::Key { line: number, key: key.into() };
            refused = Some(fault(&self.source_name, place, found, expected));
            None
        };
        let outcome = members(line, |key, value| {
            let slot = match usual.next() {
                Some((slot, name)) if *name == key => *slot,
                _ => self.slots.get(&*key).copied(),
            };
            let Some(slot) = slot else {
                if self.others {
                    return after_any(value);
                }
                return refuse(
                    &key,
                    "a key that the first line has not".into(),
                    "the same keys on each line",
                );
            };
            if columns[slot].len() > rows {
                return refuse(&key, "the key twice".into(), "it once on a line");
            }
            match finite_or_missing(value) {
                Some((value, end)) => {
                    columns[slot].push(value);
                    Some(end)
                }
                None => {
                    let end =
                        after_any(value).unwrap_or_else(|| memchr2(b',', b'}', value).unwrap_or(value.len()));
                    refuse(&key, quoted(&value[..end]), "a finite number or null")
                }
            }
        });
        match (outcome, refused) {
            (Ok(()), _) => Ok(()),
            (Err(_), Some(refused)) => Err(refused),
            (Err(at), None) => Err(not_an_object(&self.source_name, number, &line[at..])),
        }
    }
}

/// Goes through the members of the object that is the whole line. `member` takes a key and the text from its
/// value on, and says where the value ends. The error is the place of what cannot be an object.
#[inline]
fn members<'a>(
    line: &'a [u8],
    mut member: impl FnMut(Cow<'a, str>, &'a [u8]) -> Option<usize>,
) -> Result<(), usize> {
    let expect =
        |at: usize, byte: u8| if line.get(at) == Some(&byte) { Ok(blanks(line, at + 1)) } else { Err(at) };
    let end = |at: usize| if at == line.len() { Ok(()) } else { Err(at) };
    let mut at = expect(0, b'{')?;
    if line.get(at) == Some(&b'}') {
        return end(at + 1);
    }
    loop {
        let (key, behind) = key(line, at).ok_or(at)?;
        let value = expect(blanks(line, behind), b':')?;
        at = blanks(line, value + member(key, &line[value..]).ok_or(value)?);
        match line.get(at) {
            Some(b',') => at = blanks(line, at + 1),
            Some(b'}') => return end(at + 1),
            _ => return Err(at),
        }
    }
}

#[inline]
fn blanks(line: &[u8], mut at: usize) -> usize {
    while matches!(line.get(at), Some(b' ' | b'\t' | b'\r')) {
        at += 1;
    }
    at
}

/// The string at `at` and the place behind it.
#[inline]
fn key(line: &[u8], at: usize) -> Option<(Cow<'_, str>, usize)> {
    let text = line.get(at..)?.strip_prefix(b"\"")?;
    let end = memchr2(b'"', b'\\', text)?;
    if text[end] == b'"' {
        return Some((Cow::Borrowed(std::str::from_utf8(&text[..end]).ok()?), at + end + 2));
    }
    let mut strings = serde_json::Deserializer::from_slice(&line[at..]).into_iter::<String>();
    let key = strings.next()?.ok()?;
    Some((Cow::Owned(key), at + strings.byte_offset()))
}

/// The number that the text begins with, NaN for null and NaN, and where it ends.
#[inline]
fn finite_or_missing(text: &[u8]) -> Option<(f64, usize)> {
    let (value, end) = match text.first()? {
        b'-' | b'0'..=b'9' => parse_partial::<f64, _>(text).ok().filter(|(value, _)| value.is_finite())?,
        _ if text.starts_with(b"null") => (f64::NAN, 4),
        _ if text.get(..3)?.eq_ignore_ascii_case(b"nan") => (f64::NAN, 3),
        _ => return None,
    };
    matches!(text.get(end), Some(b',' | b'}' | b' ' | b'\t') | None).then_some((value, end))
}

/// Where the value of whatever kind ends that the text begins with.
#[inline]
fn after_any(text: &[u8]) -> Option<usize> {
    if let Some((_, end)) = finite_or_missing(text) {
        return Some(end);
    }
    match parse_partial::<f64, _>(text) {
        Ok((value, end)) if value.is_infinite() => Some(end),
        _ => {
            let mut values = serde_json::Deserializer::from_slice(text).into_iter::<IgnoredAny>();
            values.next()?.ok()?;
            Some(values.byte_offset())
        }
    }
}
