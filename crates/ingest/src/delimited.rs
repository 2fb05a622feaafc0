//! Lines of values between separators, as a mapping describes them.

use memchr::memchr;
use tables::{COLUMN_LIMIT, LINE_LIMIT, Place};

use crate::Error;
use crate::error::quoted;
use crate::mapping::{From, Mapping};
use crate::piece::Piece;
use crate::text::{RowFault, Rows, Source, decoded, in_parts, lines, split_line};
use crate::times::Times;

/// Reads a file.
///
/// # Errors
///
/// A header without a column that the mapping names; with line and column, a value that is no number in the mapping's notation or no
/// time, a row with more or fewer values than the header has names.
pub fn read(source: &Source, mapping: &Mapping) -> Result<Piece, Error> {
    let times = Times::new(source, mapping.time.as_ref(), mapping.decimal)?;
    let (names, first_line, data) = header(source, mapping)?;
    let comment = mapping.comment.as_deref().map(str::as_bytes);
    let is_row =
        |line: &[u8]| !line.trim_ascii().is_empty() && !comment.is_some_and(|mark| line.starts_with(mark));
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
        mapping,
        times: &times,
        slots: slots(source, mapping, names.as_deref(), width)?,
        missing: mapping.missing.iter().filter_map(|text| text.replace(',', ".").parse().ok()).collect(),
        names,
    };
    let rows = in_parts(data, first_line, |part, line| parser.parse(part, line, &is_row));
    let mut piece = Piece::mapped(source, "CSV", mapping, &times, rows.map_err(|fault| fault.of(source))?)?;
    if std::str::from_utf8(&source.bytes[..source.bytes.len() - data.len()]).is_err() {
        piece.notes.push("the header is not in UTF-8 and was read as Latin-1".into());
    }
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
    source.fault(Place::Line(line.into()), format!("{width} columns"), expected)
}

/// Names of the columns where a line has them, the number of the line after it, and the rest.
fn header<'a>(source: &'a Source, mapping: &Mapping) -> Result<(Option<Vec<String>>, u32, &'a [u8]), Error> {
    let (mut names, mut rest, mut number) = (None, source.bytes.as_slice(), 1);
    let first_row = mapping.first_row_line.unwrap_or(mapping.header_line.map_or(1, |line| line + 1));
    while number < first_row {
        if rest.is_empty() {
            let expected =
                format!("the first row on line {first_row}, as the mapping says; was it copied in full?");
            return Err(source.fault(Place::Whole, format!("{} lines", number - 1), expected));
        }
        let (line, after) = split_line(rest);
        if Some(number) == mapping.header_line {
            let mark = mapping.comment.as_deref().unwrap_or_default();
            let line = line.strip_prefix(mark.as_bytes()).unwrap_or(line);
            let fields = fields(line, mapping.separator).into_iter();
            names = Some(fields.map(|name| decoded(name).trim().to_string()).collect());
        }
        rest = after;
        number += 1;
    }
    Ok((names, first_row, rest))
}

/// Where the value of a column of the file goes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Slot {
    Skipped,
    Value(usize),
    Time(usize),
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
        let place = Place::Line(mapping.header_line.unwrap_or(1).into());
        let column = match (from, names) {
            (From::Number(number), _) if *number <= width => number - 1,
            (From::Number(number), _) => {
                let expected = format!("column {number}, which the mapping takes");
                return Err(source.fault(place, format!("{width} columns"), expected));
            }
            (From::Name(name), None) => {
                let expected =
                    format!("`header_line` in the mapping, so that {name:?} can be found, or its number");
                return Err(source.fault(place, "no names of columns", expected));
            }
            (From::Name(name), Some(names)) => {
                let mut met = (0..width).filter(|column| names[*column] == name.trim());
                match (met.next(), met.next()) {
                    (Some(column), None) => column,
                    (Some(_), Some(_)) => {
                        let found = format!("two columns {name:?}");
                        return Err(source.fault(
                            place,
                            found,
                            "in the mapping, the number of the one that is meant",
                        ));
                    }
                    (None, _) => {
                        let found = format!("no column {name:?} among {}", listed(names));
                        return Err(source.fault(
                            place,
                            found,
                            "the columns that the mapping takes; is its separator right?",
                        ));
                    }
                }
            }
        };
        if slots[column] != Slot::Skipped {
            let found = format!("column {} twice", column + 1);
            return Err(source.fault(place, found, "each column once in the mapping"));
        }
        slots[column] = slot;
    }
    Ok(slots)
}

fn listed(names: &[String]) -> String {
    const SHOWN: usize = 20;
    let mut text = names[..names.len().min(SHOWN)].join(", ");
    if names.len() > SHOWN {
        text.push_str(&format!(", and {} more", names.len() - SHOWN));
    }
    text
}

/// The fields of a line: between separators, quotes taken off; of blanks any number is one separator.
pub fn fields(line: &[u8], separator: char) -> Vec<&[u8]> {
    let mut all = Vec::new();
    let mut rest = Some(line);
    while let Some(line) = rest {
        match next_field(line, separator as u8) {
            Some((field, after)) => {
                all.push(field);
                rest = after;
            }
            None => break,
        }
    }
    all
}

/// The first field of a line, and the rest after its separator; None where blanks are all that is left.
#[inline]
fn next_field(line: &[u8], separator: u8) -> Option<(&[u8], Option<&[u8]>)> {
    if separator == b' ' {
        let line = line.trim_ascii_start();
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        return (!line.is_empty()).then(|| (&line[..end], Some(&line[end..])));
    }
    if line.first() == Some(&b'"') {
        let mut at = 1;
        // A quote within quotes is written twice.
        while let Some(end) = memchr(b'"', &line[at..]) {
            at += end + 1;
            if line.get(at) != Some(&b'"') {
                let end = memchr(separator, &line[at..]).map_or(line.len(), |end| at + end);
                return Some((&line[1..at - 1], line.get(end + 1..).filter(|_| end < line.len())));
            }
            at += 1;
        }
    }
    Some(match memchr(separator, line) {
        Some(end) => (&line[..end], Some(&line[end + 1..])),
        None => (line, None),
    })
}

struct Parser<'a> {
    mapping: &'a Mapping,
    times: &'a Times,
    slots: Vec<Slot>,
    missing: Vec<f64>,
    names: Option<Vec<String>>,
}

impl Parser<'_> {
    fn parse(&self, part: &[u8], first_line: u32, is_row: &impl Fn(&[u8]) -> bool) -> Result<Rows, RowFault> {
        let mut rows = Rows { columns: vec![Vec::new(); self.mapping.columns.len()], ..Rows::default() };
        let parts = self.mapping.time.as_ref().map_or(0, |time| time.columns.len());
        let mut time: Vec<&[u8]> = vec![b""; parts];
        let mut joined = Vec::new();
        let (mut rest, mut number) = (part, first_line);
        while !rest.is_empty() {
            let (line, after) = split_line(rest);
            rest = after;
            if is_row(line) {
                if line.len() > LINE_LIMIT {
                    let found = format!("a line of {} bytes", line.len());
                    return Err(RowFault {
                        line: number,
                        column: None,
                        found,
                        expected: "a row of values".into(),
                    });
                }
                if self.row(line, number, &mut rows, &mut time)? {
                    rows.lines.push(number);
                    if !self.times.are_counted() {
                        let text = if let [only] = time[..] {
                            only.trim_ascii()
                        } else {
                            joined.clear();
                            time.iter().for_each(|part| {
                                joined.extend_from_slice(part.trim_ascii());
                                joined.push(b' ');
                            });
                            joined.trim_ascii()
                        };
                        let read = self.times.read(text);
                        rows.times_ns.push(read.map_err(|expected| self.no_time(number, text, expected))?);
                    }
                }
            }
            number += 1;
        }
        Ok(rows)
    }

    /// Takes a row's values; false for a row in which nothing stands at all, such as `;;;`.
    #[inline]
    fn row<'a>(
        &self,
        line: &'a [u8],
        number: u32,
        rows: &mut Rows,
        time: &mut [&'a [u8]],
    ) -> Result<bool, RowFault> {
        let separator = self.mapping.separator as u8;
        let (mut rest, mut column) = (Some(line), 0);
        while let Some((field, after)) = rest.and_then(|line| next_field(line, separator)) {
            match self.slots.get(column) {
                None => return Err(self.unequal(line, number)),
                Some(Slot::Skipped) => {}
                Some(Slot::Time(part)) => time[*part] = field,
                Some(Slot::Value(value)) => match self.value(field) {
                    Some(read) => rows.columns[*value].push(read),
                    None => return Err(self.no_number(number, column, field)),
                },
            }
            column += 1;
            rest = after;
        }
        if column == self.slots.len() {
            return if line.iter().all(|byte| *byte == separator || byte.is_ascii_whitespace()) && column > 1 {
                rows.columns.iter_mut().for_each(|values| values.truncate(values.len() - 1));
                Ok(false)
            } else {
                Ok(true)
            };
        }
        Err(self.unequal(line, number))
    }

    /// A number, or NaN for a missing one; None for what is neither.
    #[inline]
    fn value(&self, field: &[u8]) -> Option<f64> {
        let field = field.trim_ascii();
        if field.is_empty() {
            return Some(f64::NAN);
        }
        let value = if self.mapping.decimal == ',' {
            comma_number(field)
        } else {
            fast_float2::parse::<f64, _>(field).ok()
        };
        match value {
            Some(value) if value.is_finite() && !self.missing.contains(&value) => Some(value),
            Some(value) if value.is_finite() => Some(f64::NAN),
            _ => self.missing_word(field).then_some(f64::NAN),
        }
    }

    #[cold]
    fn missing_word(&self, field: &[u8]) -> bool {
        field.eq_ignore_ascii_case(b"nan")
            || field.eq_ignore_ascii_case(b"null")
            || field == b"NA"
            || self.mapping.missing.iter().any(|text| text.as_bytes() == field)
    }

    fn no_number(&self, line: u32, column: usize, field: &[u8]) -> RowFault {
        let found = quoted(field.trim_ascii());
        let own = self.mapping.decimal;
        let other = if own == ',' { '.' } else { ',' };
        let marked =
            field.contains(&(other as u8)) && decoded(field).trim().replace(',', ".").parse::<f64>().is_ok();
        let expected = if field.starts_with(b"\"") {
            "a closing quote on the same line".to_string()
        } else if marked {
            format!(
                "a number with the decimal mark {own:?}; where the file writes {other:?}, say \"decimal\": \"{other}\" in the mapping"
            )
        } else {
            format!(
                "a number, or nothing where one is missing; if {found} stands for a missing one, add it to \"missing\" in the mapping"
            )
        };
        let name = match &self.names {
            Some(names) => names[column].clone(),
            None => self.target(column),
        };
        RowFault { line, column: Some((column + 1, name)), found, expected }
    }

    /// What a column without a name becomes.
    fn target(&self, column: usize) -> String {
        match self.slots[column] {
            Slot::Value(value) => self.mapping.columns[value].to.clone(),
            _ => "time".into(),
        }
    }

    fn no_time(&self, line: u32, text: &[u8], expected: String) -> RowFault {
        let column = self.slots.iter().position(|slot| *slot == Slot::Time(0)).unwrap_or_default();
        let name = self.names.as_ref().map_or_else(|| "time".to_string(), |names| names[column].clone());
        RowFault { line, column: Some((column + 1, name)), found: quoted(text), expected }
    }

    fn unequal(&self, line: &[u8], number: u32) -> RowFault {
        let found = format!("{} values", fields(line, self.mapping.separator).len());
        let expected = match &self.names {
            Some(names) => format!(
                "{}, one for each name in the header; was the file cut, or is the separator another?",
                names.len()
            ),
            None => format!(
                "{}, as on the first row; was the file cut, or is the separator another?",
                self.slots.len()
            ),
        };
        RowFault { line: number, column: None, found, expected }
    }
}

/// A number with a decimal comma.
#[inline]
fn comma_number(field: &[u8]) -> Option<f64> {
    let mut text = [0_u8; 64];
    let text = text.get_mut(..field.len())?;
    for (to, byte) in text.iter_mut().zip(field) {
        *to = match byte {
            b',' => b'.',
            b'.' => return None,
            byte => *byte,
        };
    }
    fast_float2::parse::<f64, _>(&*text).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_between_separators() {
        let of = |line: &str, separator: char| -> Vec<String> {
            fields(line.as_bytes(), separator).into_iter().map(|field| decoded(field).into_owned()).collect()
        };
        assert_eq!(of("a,b,,c", ','), ["a", "b", "", "c"]);
        assert_eq!(of("a;b;", ';'), ["a", "b", ""]);
        assert_eq!(of("\"a,b\",\"c\"\"d\",e", ','), ["a,b", "c\"\"d", "e"]);
        assert_eq!(of("  a \t b  ", ' '), ["a", "b"]);
        assert_eq!(of("\"x\"", ','), ["x"]);
    }

    #[test]
    fn numbers_with_a_comma() {
        assert_eq!(comma_number(b"48520,3"), Some(48520.3));
        assert_eq!(comma_number(b"48.520,3"), None);
        assert_eq!(comma_number(b"-1,5e3"), Some(-1500.0));
    }
}
