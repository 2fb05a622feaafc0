//! Rows of values, as the mapping writes them.

use common::number::counted;

use super::fields::{fields, next_field};
use crate::Error;
use crate::mapping::Mapping;
use crate::number;
use crate::parts::Room;
use crate::text::{Source, decoded, lines_from, quoted};
use crate::times::Times;

/// Where the value of a column of the file goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slot {
    Skipped,
    Value(usize),
    Time(usize),
}

pub struct Parser<'a> {
    pub source: &'a Source,
    pub mapping: &'a Mapping,
    pub times: &'a Times,
    pub slots: Vec<Slot>,
    /// Numbers that stand for a missing value.
    pub missing: Vec<f64>,
    pub names: Option<Vec<String>>,
}

impl Parser<'_> {
    /// Reads the rows of a part; `is_row` tells them from comments and empty lines.
    pub fn parse(
        &self,
        part: &[u8],
        first_line: u32,
        room: &mut Room,
        is_row: &impl Fn(&[u8]) -> bool,
    ) -> Result<(), Error> {
        let parts = self.mapping.time.as_ref().map_or(0, |time| time.columns.len());
        let mut time: Vec<&[u8]> = vec![b""; parts];
        let mut joined = Vec::new();
        for (number, line) in lines_from(part, first_line).filter(|(_, line)| is_row(line)) {
            self.source.check_length(number, line)?;
            if !self.row(line, number, room, &mut time)? {
                continue;
            }
            let text = match &time[..] {
                [] => &[][..],
                [only] => only.trim_ascii(),
                several => {
                    joined.clear();
                    several.iter().for_each(|part| {
                        joined.extend_from_slice(part.trim_ascii());
                        joined.push(b' ');
                    });
                    joined.trim_ascii()
                }
            };
            let read = self.times.read(text);
            room.end_row(read.map_err(|expected| self.no_time(number, text, expected))?, number);
        }
        Ok(())
    }

    /// Takes a row's values; false for a row in which nothing stands at all, such as `;;;`.
    #[inline]
    fn row<'a>(
        &self,
        line: &'a [u8],
        number: u32,
        room: &mut Room,
        time: &mut [&'a [u8]],
    ) -> Result<bool, Error> {
        let separator = self.mapping.separator as u8;
        let (mut rest, mut column) = (Some(line), 0);
        while let Some(text) = rest {
            if let Some(Slot::Value(value)) = self.slots.get(column)
                && let Some((read, after)) = self.plain_value(text)
            {
                room.set(*value, read);
                column += 1;
                rest = after;
                continue;
            }
            let Some((field, after)) = next_field(text, separator) else { break };
            match self.slots.get(column) {
                None => return Err(self.unequal(line, number)),
                Some(Slot::Skipped) => {}
                Some(Slot::Time(part)) => time[*part] = field,
                Some(Slot::Value(value)) => match self.value(field) {
                    Some(read) => room.set(*value, read),
                    None => return Err(self.no_number(number, column, field)),
                },
            }
            column += 1;
            rest = after;
        }
        if column == self.slots.len() {
            let nothing = |byte: &u8| *byte == separator || byte.is_ascii_whitespace();
            return Ok(column == 1 || !line.iter().all(nothing));
        }
        Err(self.unequal(line, number))
    }

    /// The number that a line begins with and what follows its separator, where it is a plain one right
    /// before that or the line's end.
    #[inline]
    fn plain_value<'a>(&self, text: &'a [u8]) -> Option<(f64, Option<&'a [u8]>)> {
        let (value, end) = number::plain(text, self.mapping.decimal as u8)?;
        let after = match text.get(end) {
            None => None,
            Some(mark) if *mark == self.mapping.separator as u8 => Some(&text[end + 1..]),
            Some(_) => return None,
        };
        Some((self.unless_missing(value), after))
    }

    fn unless_missing(&self, value: f64) -> f64 {
        if self.missing.contains(&value) { f64::NAN } else { value }
    }

    /// A number, or NaN for a missing one; None for what is neither.
    #[inline]
    fn value(&self, field: &[u8]) -> Option<f64> {
        let field = field.trim_ascii();
        if field.is_empty() {
            return Some(f64::NAN);
        }
        let parsed = match self.mapping.thousands {
            Some(mark) if field.contains(&(mark as u8)) => {
                number::grouped(field, self.mapping.decimal as u8, mark as u8)
            }
            _ => number::parse(field, self.mapping.decimal as u8),
        };
        match parsed {
            Some(value) if value.is_finite() => Some(self.unless_missing(value)),
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

    fn no_number(&self, line: u32, column: usize, field: &[u8]) -> Error {
        let found = quoted(field.trim_ascii());
        let own = self.mapping.decimal;
        let other = if own == ',' { '.' } else { ',' };
        let marked = other != self.mapping.separator
            && field.contains(&(other as u8))
            && decoded(field).trim().replace(',', ".").parse::<f64>().is_ok();
        let grouped =
            |own: char, mark: char| number::grouped(field.trim_ascii(), own as u8, mark as u8).is_some();
        let expected = if field.starts_with(b"\"") {
            "a closing quote on the same line".to_string()
        } else if marked {
            format!(
                "a number with the decimal mark {own:?}; where the file writes {other:?}, state \"decimal\": \"{other}\" in the mapping"
            )
        } else if let Some(mark) = [',', '.', '\'', ' ']
            .into_iter()
            .find(|mark| *mark != own && field.contains(&(*mark as u8)) && grouped(own, *mark))
        {
            format!(
                "a number; where {mark:?} separates thousands, state \"thousands\": \"{mark}\" in the mapping"
            )
        } else {
            format!(
                "a number, or nothing where one is missing; if {found} stands for a missing one, add it to \"missing\" in the mapping"
            )
        };
        // A column without a name goes by what becomes of it.
        let name = match (&self.names, self.slots[column]) {
            (Some(names), _) => &names[column],
            (None, Slot::Value(value)) => &self.mapping.columns[value].to,
            _ => "time",
        };
        self.source.in_field(line, (column + 1, name), found, expected)
    }

    fn no_time(&self, line: u32, text: &[u8], expected: String) -> Error {
        let column = self.slots.iter().position(|slot| *slot == Slot::Time(0)).unwrap_or_default();
        let name = self.names.as_ref().map_or("time", |names| &names[column]);
        self.source.in_field(line, (column + 1, name), quoted(text), expected)
    }

    fn unequal(&self, line: &[u8], number: u32) -> Error {
        let found = counted(fields(line, self.mapping.separator).len(), "value");
        let like =
            if self.names.is_some() { "one for each name in the header" } else { "as on the first row" };
        let count = self.slots.len();
        let expected = format!("{count}, {like}; was the file cut, or is the separator another?");
        self.source.in_line(number, found, expected)
    }
}
