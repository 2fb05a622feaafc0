//! Rows: date, time, day of the year, and a value for each title.

use super::header::Header;
use crate::Error;
use crate::clock::{self, DAY_NS};
use crate::fill;
use crate::number;
use crate::parts::{Room, Rows, in_parts};
use crate::text::{Source, lines_from, quoted};
use common::number::counted;
use rayon::prelude::*;

/// A row has a date, a time of day, a day of the year and a value.
const LEAST_BYTES: usize = 20;

/// Readings as they stand, and how often each component was not observed (88888).
pub struct Data {
    /// Values in the units of the file: nT, minutes of arc for D and I.
    pub rows: Rows,
    pub not_observed: Vec<usize>,
}

pub fn read(source: &Source, header: &Header, components: &[char], trust_rows: bool) -> Result<Data, Error> {
    let data = header.data(source);
    let parser = Parser { source, titles: &header.titles, trust_rows };
    let parse = |part: &[u8], first_line: u32, room: &mut Room| {
        // The day of the row before: seldom another.
        let mut day = Day::default();
        let rows = lines_from(part, first_line).map(|(number, line)| (number, trimmed(line)));
        let mut rows = rows.filter(|(_, text)| !text.is_empty() && text[0] != b'#');
        rows.try_for_each(|(number, text)| parser.row(text, number, room, &mut day))
    };
    let mut rows = in_parts(data, header.titles_line + 1, components.len(), LEAST_BYTES, parse)?;
    if !data.ends_with(b"\n") {
        parser.check_end(data, &rows)?;
    }
    let not_observed =
        rows.columns.par_iter_mut().map(|values| fill::without(values, true).not_observed).collect();
    Ok(Data { rows, not_observed })
}

struct Parser<'a> {
    source: &'a Source,
    titles: &'a [String],
    trust_rows: bool,
}

impl Parser<'_> {
    #[inline]
    fn row(&self, text: &[u8], line: u32, room: &mut Room, day: &mut Day) -> Result<(), Error> {
        let fault = |column: (usize, &str), found: String, expected: &str| {
            Err(self.source.in_field(line, column, found, expected))
        };
        let (date, rest) = word(text);
        if day.text != date.get(..10).unwrap_or_default() || date.len() != 10 {
            let Some(next) = Day::of(date) else {
                if text.get(..6).is_some_and(|word| word.eq_ignore_ascii_case(b"Format")) {
                    let expected = "rows; give concatenated files one by one";
                    return Err(self.source.in_line(line, "a header among the rows", expected));
                }
                return fault((1, "DATE"), quoted(date), "a date as in 2014-11-01");
            };
            *day = next;
        }
        let (time, rest) = word(rest);
        let Some((time_ns, _)) = clock::time_of_day(time).filter(|(_, end)| *end == time.len()) else {
            return fault((2, "TIME"), quoted(time), "a time of day as in 23:59:00.000");
        };
        let (of_year, mut rest) = word(rest);
        if !self.trust_rows
            && of_year != &day.of_year_text[3 - of_year.len().clamp(1, 3)..]
            && !day.is(of_year)
        {
            let date = String::from_utf8_lossy(&day.text);
            let found = format!("{} where {date} is day {}", quoted(of_year), day.of_year);
            let expected =
                "the day of the year that the date is; where DATE is right, --trust-rows passes over DOY";
            return fault((3, "DOY"), found, expected);
        }
        for (index, title) in self.titles.iter().enumerate() {
            rest = rest.trim_ascii_start();
            if rest.is_empty() {
                let found = format!("{index} of {}", counted(self.titles.len(), "value"));
                return Err(self.source.in_line(line, found, "one for each title; was the file cut?"));
            }
            match number::plain(rest, b'.').or_else(|| fast_float2::parse_partial(rest).ok()) {
                Some((value, end))
                    if value.is_finite() && rest.get(end).is_none_or(u8::is_ascii_whitespace) =>
                {
                    room.set(index, value);
                    rest = &rest[end..];
                }
                _ => {
                    let expected =
                        "a number, 99999.00 where one is missing, 88888.00 where none was observed";
                    return fault((4 + index, title), quoted(word(rest).0), expected);
                }
            }
        }
        if !rest.trim_ascii().is_empty() {
            let found = format!("{} after the last value", quoted(rest.trim_ascii()));
            let expected = format!("{}, one for each title", counted(self.titles.len(), "value"));
            return Err(self.source.in_line(line, found, expected));
        }
        room.end_row(day.start_ns + time_ns, line);
        Ok(())
    }

    /// A last line without end that is shorter than the one before, where those two are alike: a value was
    /// cut.
    fn check_end(&self, data: &[u8], rows: &Rows) -> Result<(), Error> {
        let mut lines = data.rsplit(|byte| *byte == b'\n').map(trimmed);
        let [Some(last), Some(before), Some(first)] = [lines.next(), lines.next(), lines.next()] else {
            return Ok(());
        };
        if before.len() == first.len() && last.len() < before.len() && !last.is_empty() {
            let cut = last.rsplit(u8::is_ascii_whitespace).next().unwrap_or(last);
            let found = format!("a last line that breaks off at {}", quoted(cut));
            let expected =
                format!("{} as on the lines before; was the file cut?", counted(before.len(), "character"));
            let line = rows.lines.last().copied().unwrap_or(0);
            return Err(self.source.in_line(line, found, expected));
        }
        Ok(())
    }
}

/// A date that rows have in common.
#[derive(Default)]
struct Day {
    text: [u8; 10],
    start_ns: i64,
    of_year: i64,
    /// In three digits.
    of_year_text: [u8; 3],
}

impl Day {
    fn of(text: &[u8]) -> Option<Self> {
        let (day, year) = clock::date(text).filter(|_| text.len() == 10)?;
        let of_year = day - clock::day(year, 1, 1)? + 1;
        let digit = |unit: i64| b'0' + (of_year / unit % 10) as u8;
        let of_year_text = [digit(100), digit(10), digit(1)];
        Some(Day { text: *text.first_chunk()?, start_ns: day * DAY_NS, of_year, of_year_text })
    }

    /// Whether a day of the year is this one, however it is written.
    #[cold]
    fn is(&self, text: &[u8]) -> bool {
        std::str::from_utf8(text).ok().and_then(|text| text.parse().ok()) == Some(self.of_year)
    }
}

/// Without blanks and the bar at the end.
#[inline]
fn trimmed(line: &[u8]) -> &[u8] {
    let line = line.trim_ascii();
    line.strip_suffix(b"|").unwrap_or(line).trim_ascii_end()
}

#[inline]
fn word(text: &[u8]) -> (&[u8], &[u8]) {
    let text = text.trim_ascii_start();
    text.split_at(text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len()))
}
