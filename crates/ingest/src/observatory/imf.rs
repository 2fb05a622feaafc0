//! Minute values as INTERMAGNET's data centres hand them on (IMF 1.22, 1.23): for each hour a header, then 30 lines
//! of two minutes, in tenths of nT; D and I in hundredths of a minute of arc.
//!
//! `FLX MAR1024 070 00 HDZF A EDI 04210158 000000 RRRRRRRRRRRRRRRR`.

use super::{Components, elements, header, scaled, whole_numbers};
use crate::Error;
use crate::clock::{self, DAY_NS, SECOND_NS};
use crate::piece::Piece;
use crate::text::{Source, decoded, lines, quoted};

const MONTHS: [&str; 12] =
    ["JAN", "FEB", "MAR", "APR", "MAY", "JUN", "JUL", "AUG", "SEP", "OCT", "NOV", "DEC"];
/// Types of data as IAGA-2002 calls them.
const KINDS: [(&str, &str); 4] =
    [("R", "Reported"), ("A", "Adjusted"), ("Q", "Quasi-definitive"), ("D", "Definitive")];
/// Seven digits: a missing value is the largest.
const MOST: i64 = 9_999_999;
/// Minutes of a block.
const BLOCK: i64 = 60;

/// The header of an hour.
#[derive(PartialEq)]
pub struct Header {
    station: String,
    letters: Vec<char>,
    kind: String,
    /// Colatitude and longitude, four digits each, tenths of a degree.
    place: String,
    /// Base line of D, tenths of a minute of arc.
    base: i64,
}

impl Header {
    /// A line, where it is such a header, and its words.
    pub fn of(line: &str) -> Option<(Self, Vec<&str>)> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [station, date, _, _, letters, kind, _, place, base, ..] = words[..] else { return None };
        let letters = elements(letters)?;
        month(date)?;
        let meant = date.len() == 7 && letters.len() == 4 && kind.len() == 1;
        let [station, kind, place] = [station, kind, place].map(String::from);
        let base = base.parse().ok()?;
        meant.then_some((Header { station, letters, kind, place, base }, words))
    }

    /// Latitude and longitude in degrees as text; empty where the header does not say them.
    fn degrees(&self) -> [String; 2] {
        let tenths = |text: Option<&str>| text.and_then(|text| text.parse::<f64>().ok());
        let [colatitude, longitude] = [self.place.get(..4), self.place.get(4..)].map(tenths);
        [colatitude.map(|tenths| 900.0 - tenths), longitude]
            .map(|tenths| tenths.map_or_else(String::new, |tenths| format!("{:.1}", tenths / 10.0)))
    }
}

/// The number of the month with which a date begins, from 1.
fn month(date: &str) -> Option<i64> {
    let name = date.get(..3)?;
    MONTHS.iter().zip(1..).find(|(month, _)| name.eq_ignore_ascii_case(month)).map(|(_, number)| number)
}

/// When the hour of a header begins: ns since 1970.
fn hour_ns(words: &[&str]) -> Option<i64> {
    let number = |text: Option<&str>| text?.parse::<i64>().ok();
    let [date, of_year, hour, ..] = words.get(1..)? else { return None };
    let (of_month, year) = (number(date.get(3..5))?, number(date.get(5..))?);
    // INTERMAGNET began in 1991.
    let year = year + if year < 70 { 2000 } else { 1900 };
    let day = clock::day(year, month(date)?, of_month)?;
    let is_it = number(Some(of_year))? == day - clock::day(year, 1, 1)? + 1;
    let hour = number(Some(hour)).filter(|hour| (0..24).contains(hour) && is_it)?;
    Some(day * DAY_NS + hour * 3600 * SECOND_NS)
}

/// The second value is the base line of D, minutes of arc.
pub fn read(source: &Source, piece: &mut Piece) -> Result<(Components, Option<f64>), Error> {
    let mut first: Option<Header> = None;
    let mut columns = vec![Vec::new(); 4];
    // When the block begins, and how many of its minutes were read.
    let (mut start_ns, mut minutes, mut last) = (0, BLOCK, 1);
    let cut = "60 minutes after each header, missing ones filled with 9; was the file cut?";
    for (number, line) in lines(&source.bytes).filter(|(_, line)| !line.trim_ascii().is_empty()) {
        let text = decoded(line);
        let refused = |found: String, expected: &str| Err(source.in_line(number, found, expected));
        last = number;
        if let Some((header, words)) = Header::of(&text) {
            if minutes < BLOCK {
                return refused(format!("a header after {minutes} minutes"), cut);
            }
            let Some(ns) = hour_ns(&words) else {
                let expected = "a day, the same as day of the year, and an hour, as in MAR1024 070 23";
                return refused(quoted(words[1..4].join(" ").as_bytes()), expected);
            };
            if first.as_ref().is_some_and(|first| *first != header) {
                let expected = "station, components, data type, place and base line as in the first header; give such files one by one";
                return refused(quoted(line), expected);
            }
            (first, start_ns, minutes) = (Some(header), ns, 0);
            continue;
        }
        let values = whole_numbers(&text, MOST).filter(|values| values.len() == 8);
        let (Some(header), Some(values)) = (&first, values) else {
            let expected = "eight whole numbers of seven digits at most, four for each of two minutes; was the file cut?";
            return refused(quoted(line), expected);
        };
        if minutes >= BLOCK {
            return refused("a row after 60 minutes".into(), "the header of the next hour");
        }
        for minute in values.chunks_exact(4) {
            piece.times_ns.push(start_ns + minutes * 60 * SECOND_NS);
            piece.lines.push(number);
            for ((letter, column), value) in header.letters.iter().zip(&mut columns).zip(minute) {
                column.push(scaled(*value, if matches!(letter, 'D' | 'I') { 100.0 } else { 10.0 }));
            }
            minutes += 1;
        }
    }
    let Some(first) = first.filter(|_| minutes == BLOCK) else {
        return Err(source.in_line(last, format!("the end after {minutes} minutes"), cut));
    };
    let [latitude, longitude] = first.degrees();
    piece.station = Some(first.station.clone());
    let kind = KINDS.into_iter().find(|(code, _)| *code == first.kind);
    let records = header([
        ("Format", "IMF 1".into()),
        ("IAGA Code", first.station.clone()),
        ("Geodetic Latitude", latitude),
        ("Geodetic Longitude", longitude),
        ("Reported", first.letters.iter().collect()),
        ("Data Interval Type", "1-minute".into()),
        ("Data Type", kind.map_or("", |(_, name)| name).into()),
    ]);
    piece.header.insert("header".into(), records);
    let base = Some(first.base as f64 / 10.0).filter(|base| *base != 0.0);
    Ok(((first.letters, columns), base))
}
