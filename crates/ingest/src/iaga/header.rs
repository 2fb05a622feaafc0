//! The records before the data: twelve with a label (thirteen since 2015), comments, and the titles of the
//! columns.

use common::Extra;
use serde_json::Value;
use tables::Place;

use super::components::LETTERS;
use crate::Error;
use crate::text::{Source, decoded, lines};

const LABELS: [&str; 13] = [
    "Format",
    "Source of Data",
    "Station Name",
    "IAGA Code",
    "Geodetic Latitude",
    "Geodetic Longitude",
    "Elevation",
    "Reported",
    "Sensor Orientation",
    "Digital Sampling",
    "Data Interval Type",
    "Data Type",
    "Publication Date",
];
/// Records before the titles that are read at most.
const MOST: u32 = 100_000;

#[derive(Default)]
pub struct Header {
    /// The station's code; None where it is blank.
    pub station: Option<String>,
    pub titles_line: u32,
    /// Titles of the components, `BOUX`.
    pub titles: Vec<String>,
    /// Records by label, with their lines.
    records: Vec<(u32, String, String)>,
    comments: Vec<String>,
}

impl Header {
    pub fn read(source: &Source) -> Result<Self, Error> {
        let mut header = Header::default();
        for (number, line) in lines(&source.bytes).take_while(|(number, _)| *number < MOST) {
            let text = without_bar(line);
            let inner = text.trim_start();
            if inner.get(..4).is_some_and(|word| word.eq_ignore_ascii_case("DATE")) {
                header.titles_line = number;
                header.titles = titles(source, number, inner)?;
                header.station = header.record("IAGA Code").map(str::to_string);
                return Ok(header);
            }
            if inner.as_bytes().first().is_some_and(u8::is_ascii_digit) {
                let expected = "the titles (DATE TIME DOY …) before the first row";
                return Err(source.in_line(number, "a row", expected));
            }
            if let Some(comment) = inner.strip_prefix('#') {
                header.comments.push(comment.trim().to_string());
            } else if !inner.is_empty() {
                let (label, content) = record(inner);
                header.records.push((number, label, content));
            }
        }
        let expected = "the titles (DATE TIME DOY …) after the header; was the file cut?";
        Err(source.fault(Place::Whole, "a header that does not end", expected))
    }

    fn record(&self, label: &str) -> Option<&str> {
        let found = self.records.iter().find(|(_, known, _)| known == label);
        found.map(|(_, _, content)| content.as_str()).filter(|content| !content.is_empty())
    }

    pub fn data<'a>(&self, source: &'a Source) -> &'a [u8] {
        let mut ends = memchr::memchr_iter(b'\n', &source.bytes);
        let end = ends.nth(self.titles_line as usize - 1);
        end.map_or(&[], |end| &source.bytes[end + 1..])
    }

    /// The letters of the components, as titles and the record `Reported` say alike. What `Sensor
    /// Orientation` says is no matter here.
    pub fn components(
        &self,
        source: &Source,
        trust_rows: bool,
        notes: &mut Vec<String>,
    ) -> Result<Vec<char>, Error> {
        let place = Place::Line(self.titles_line.into());
        let last = |title: &String| title.chars().last().unwrap_or('?').to_ascii_uppercase();
        let letters: Vec<char> = self.titles.iter().map(last).collect();
        for (index, letter) in letters.iter().enumerate() {
            if !LETTERS.contains(*letter) || letters[..index].contains(letter) {
                let expected = "titles that end in one of X Y Z H D I E F S G U V W, each once";
                return Err(source.fault(place, format!("the title {:?}", self.titles[index]), expected));
            }
        }
        let codes =
            self.titles.iter().filter_map(|title| title.get(..title.len() - 1)).find(|code| !code.is_empty());
        if let (Some(code), Some(station)) = (codes, &self.station)
            && !code.eq_ignore_ascii_case(station)
        {
            notes.push(format!("the header says station {station}, the titles say {code}"));
        }
        let reported: Option<String> = self.record("Reported").map(|text| {
            text.chars().filter(|letter| letter.is_alphabetic()).collect::<String>().to_uppercase()
        });
        if let Some(reported) = reported.filter(|reported| !reported.chars().eq(letters.iter().copied())) {
            let titles: String = letters.iter().collect();
            if !trust_rows {
                let record = self.records.iter().find(|(_, label, _)| label == "Reported");
                let line = record.map_or(0, |record| record.0);
                let found = format!("the components {reported} where the titles of the columns say {titles}");
                let expected = "the same in both; correct the header, or use the titles with --trust-rows";
                return Err(source.in_line(line, found, expected));
            }
            notes.push(format!("the header says {reported}, the titles say {titles}; the titles are used"));
        }
        Ok(letters)
    }

    /// The declared interval: its line, its words and s; None where it says none.
    pub fn interval(&self) -> Option<(u64, &str, f64)> {
        let (line, _, words) = self.records.iter().find(|(_, label, _)| label == "Data Interval Type")?;
        Some(((*line).into(), words.as_str(), interval_s(words)?))
    }

    /// The base to which D of variation data is to be added, minutes of arc: comment `DECBAS`, tenths of a
    /// minute, east. Definitive data have D in full.
    pub fn declination_base_arcmin(&self) -> Option<f64> {
        let kind = self.record("Data Type").unwrap_or_default().to_ascii_lowercase();
        if kind.starts_with('d') || kind.starts_with('q') {
            return None;
        }
        let comment = self.comments.iter().find_map(|comment| comment.strip_prefix("DECBAS"))?;
        let tenths: f64 = comment.split_whitespace().next()?.parse().ok()?;
        Some(tenths / 10.0).filter(|base| *base != 0.0)
    }

    /// The header as the document keeps it.
    pub fn kept(&self) -> Extra {
        let records = self.records.iter().filter(|(_, _, content)| !content.is_empty());
        let records: Extra =
            records.map(|(_, label, content)| (label.clone(), content.clone().into())).collect();
        let mut kept = Extra::new();
        kept.insert("header".into(), records.into());
        if !self.comments.is_empty() {
            kept.insert("comments".into(), Value::from(self.comments.clone()));
        }
        kept
    }
}

/// A record's label and what it says: the content begins in column 25, or after two blanks.
fn record(text: &str) -> (String, String) {
    let lower = text.to_ascii_lowercase();
    if let Some(label) = LABELS.iter().find(|label| lower.starts_with(&label.to_ascii_lowercase())) {
        let content = text[label.len()..].trim_start_matches([' ', ':', '\t']).trim();
        return (label.to_string(), content.to_string());
    }
    let (label, content) = text.split_once("  ").unwrap_or((text, ""));
    (label.trim().to_string(), content.trim().to_string())
}

fn titles(source: &Source, line: u32, text: &str) -> Result<Vec<String>, Error> {
    let words: Vec<&str> = text.split_whitespace().collect();
    match words.as_slice() {
        [_, time, day, titles @ ..]
            if time.eq_ignore_ascii_case("TIME") && day.eq_ignore_ascii_case("DOY") && !titles.is_empty() =>
        {
            Ok(titles.iter().map(|title| title.to_string()).collect())
        }
        _ => {
            let expected = "titles: DATE TIME DOY and one for each component, as in BOUX";
            Err(source.in_line(line, format!("{text:?}"), expected))
        }
    }
}

/// `Filtered 1-minute (00:15-01:45)`: 60 s.
fn interval_s(words: &str) -> Option<f64> {
    let before = words.split('(').next()?.to_ascii_lowercase();
    let parts: Vec<&str> = before.split([' ', '-', '_']).filter(|part| !part.is_empty()).collect();
    parts.iter().enumerate().find_map(|(index, part)| {
        let digits = part.find(|letter: char| letter.is_alphabetic()).unwrap_or(part.len());
        let (number, unit) = part.split_at(digits);
        let unit_s = match unit {
            "ms" | "millisecond" | "milliseconds" => 1e-3,
            "s" | "sec" | "second" | "seconds" => 1.0,
            "min" | "minute" | "minutes" => 60.0,
            "h" | "hr" | "hour" | "hours" | "hourly" => 3600.0,
            "day" | "days" | "daily" => 86_400.0,
            "month" | "months" | "monthly" => 28.0 * 86_400.0,
            _ => return None,
        };
        let number =
            if number.is_empty() { index.checked_sub(1).map_or("1", |before| parts[before]) } else { number };
        Some(number.parse::<f64>().unwrap_or(1.0) * unit_s)
    })
}

/// A line's text without its bar and the blanks before that.
fn without_bar(line: &[u8]) -> String {
    let text = decoded(line);
    let text = text.trim_end();
    text.strip_suffix('|').unwrap_or(text).trim_end().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_in_words() {
        for (words, seconds) in [
            ("Average 1-Minute (00:00-00:59)", 60.0),
            ("Filtered 1-second (00:00.0-00:06.0)", 1.0),
            ("1-hour", 3600.0),
            ("hourly average", 3600.0),
            ("0.5 second instantaneous", 0.5),
            ("10s", 10.0),
            ("100-millisecond", 0.1),
            ("Daily", 86_400.0),
        ] {
            assert_eq!(interval_s(words), Some(seconds), "{words}");
        }
        assert_eq!(interval_s("filtered"), None);
    }

    #[test]
    fn records_in_any_spelling() {
        assert_eq!(record("IAGA CODE              BOU"), ("IAGA Code".into(), "BOU".into()));
        assert_eq!(record("Reported: XYZF"), ("Reported".into(), "XYZF".into()));
        assert_eq!(record("Source of Data"), ("Source of Data".into(), String::new()));
        assert_eq!(record("Pier No   4"), ("Pier No".into(), "4".into()));
    }
}
