//! Times of rows as a mapping describes them.

use common::time::Start;
use jiff::civil::{Date, DateTime};
use jiff::fmt::strtime::{self, BrokenDownTime};
use tables::Place;

use crate::Error;
use crate::clock::{self, Clock, DAY_NS, SECOND_NS, Stamp, Zone};
use crate::mapping::TimeMapping;
use crate::parts::Rows;
use crate::text::Source;

pub struct Times {
    form: Form,
    zone: Zone,
    said: String,
    /// Nanoseconds that are added to each: the recording's start.
    begin_ns: i64,
    clock: Clock,
    point: u8,
}

enum Form {
    Iso,
    /// A number of units of so many ns.
    Decimal(i64),
    /// Year, and day of the year with decimals.
    DayOfYear,
    /// Days since a day so far from 1970.
    Days(f64),
    /// A pattern with the date.
    Pattern(String),
    /// A pattern of the day, and a number of units of so many ns since its midnight.
    Dated(String, i64),
    /// The time of day alone, with the day from elsewhere.
    OfDay {
        time: OfDay,
        day: i64,
        /// Whether the day is that of most rows, after which the file is named; else it is that of the first
        /// row.
        named: bool,
    },
    /// Row by row.
    Step(f64),
    None,
}

/// A time of day as it is written: by a pattern, or as a number of units of so many ns since midnight.
enum OfDay {
    Pattern(String),
    Number(i64),
}

/// A number since midnight, ns. Midnight may be the end of a day as well.
fn since_midnight(text: &[u8], unit_ns: i64, point: u8) -> Option<i64> {
    clock::decimal(text, unit_ns, point).filter(|ns| (0..=DAY_NS).contains(ns))
}

impl OfDay {
    fn read(&self, text: &[u8], point: u8) -> Option<i64> {
        match self {
            OfDay::Number(unit_ns) => since_midnight(text, *unit_ns, point),
            OfDay::Pattern(pattern) => {
                let time = strtime::parse(pattern, text).ok()?.to_time().ok()?;
                let midnight = jiff::civil::Time::midnight();
                Some((time - midnight).total(jiff::Unit::Nanosecond).ok()? as i64)
            }
        }
    }
}

impl Times {
    /// What the mapping says of a file's times. Errors: a date that should be in the file's name and is not.
    pub fn new(source: &Source, mapping: Option<&TimeMapping>, decimal: char) -> Result<Self, Error> {
        let point = decimal as u8;
        let Some(mapping) = mapping else {
            let (said, zone) = (String::new(), Zone::Fixed(0));
            return Ok(Times { form: Form::None, zone, said, begin_ns: 0, clock: Clock::None, point });
        };
        let form = match (mapping.step_s, mapping.format.as_str()) {
            (Some(step_s), _) => Form::Step(step_s),
            (None, "iso") => Form::Iso,
            (None, "unix_s" | "seconds") => Form::Decimal(SECOND_NS),
            (None, "unix_ms" | "milliseconds") => Form::Decimal(SECOND_NS / 1000),
            (None, "unix_us") => Form::Decimal(1000),
            (None, "unix_ns") => Form::Decimal(1),
            (None, "day_of_year") => Form::DayOfYear,
            (None, "excel_days") => Form::Days(25_569.0),
            (None, "matlab_days") => Form::Days(719_529.0),
            (None, said) => {
                let number = mapping.of_day();
                let time =
                    || number.map_or(OfDay::Pattern(said.into()), |(_, unit_ns, _)| OfDay::Number(unit_ns));
                let first = mapping.start.as_deref().and_then(|start| clock::date(start.as_bytes()));
                match (&mapping.date_in_name, first, number) {
                    (Some(date), ..) => {
                        Form::OfDay { time: time(), day: day_in_name(source, date)?, named: true }
                    }
                    (None, Some((day, _)), _) => Form::OfDay { time: time(), day, named: false },
                    (None, None, Some((before, unit_ns, _))) => Form::Dated(before.into(), unit_ns),
                    (None, None, None) => Form::Pattern(said.into()),
                }
            }
        };
        let counted =
            matches!(form, Form::Step(_)) || matches!(mapping.format.as_str(), "seconds" | "milliseconds");
        let start = mapping.start.as_deref().and_then(Start::parse);
        let (begin_ns, clock) = match (counted, start) {
            (false, _) => (0, Clock::Utc),
            (true, None) => (0, Clock::Campaign),
            (true, Some(start)) => ((start.unix_s * 1e6).round() as i64 * 1000, Clock::Utc),
        };
        Ok(Times { form, zone: mapping.zone(), said: mapping.format.clone(), begin_ns, clock, point })
    }

    pub fn clock(&self) -> Clock {
        self.clock
    }

    /// Whether rows hold no time.
    pub fn are_counted(&self) -> bool {
        matches!(self.form, Form::Step(_) | Form::None)
    }

    /// Reads one; what is wrong with it otherwise.
    #[inline]
    pub fn read(&self, text: &[u8]) -> Result<i64, String> {
        let as_expected = || self.expected();
        match &self.form {
            Form::Iso => clock::iso(text).ok_or_else(as_expected).and_then(|stamp| self.zone.moment(stamp)),
            Form::Decimal(unit_ns) => {
                let ns = clock::decimal(text, *unit_ns, self.point).ok_or_else(as_expected)?;
                ns.checked_add(self.begin_ns).ok_or_else(as_expected)
            }
            Form::DayOfYear => self.zone.moment(day_of_year(text, self.point).ok_or_else(as_expected)?),
            Form::Days(epoch) => {
                let clock_ns = clock::float(text, self.point).and_then(|days| clock::days(days, *epoch));
                self.zone.moment(Stamp { clock_ns: clock_ns.ok_or_else(as_expected)?, ahead_s: None })
            }
            Form::Pattern(pattern) => {
                let parts = strtime::parse(pattern, text).map_err(|_| as_expected())?;
                self.zone.moment(stamp(&parts).ok_or_else(as_expected)?)
            }
            // Brought to UTC by `settle`, when it is known on which day each row was taken.
            Form::OfDay { time, day, .. } => {
                time.read(text, self.point).map(|ns| day * DAY_NS + ns).ok_or_else(as_expected)
            }
            Form::Dated(pattern, unit_ns) => {
                let cut = text.iter().rposition(|byte| *byte == b' ').ok_or_else(as_expected)?;
                let date = strtime::parse(pattern, &text[..cut]).ok().and_then(|parts| parts.to_date().ok());
                let ns = since_midnight(&text[cut + 1..], *unit_ns, self.point);
                let (date, ns) = date.zip(ns).ok_or_else(as_expected)?;
                self.zone.moment(Stamp { clock_ns: days_of(date) * DAY_NS + ns, ahead_s: None })
            }
            Form::Step(_) | Form::None => Ok(0),
        }
    }

    /// A time that a table without text holds as a number.
    pub fn read_number(&self, value: f64) -> Result<i64, String> {
        let ns = match &self.form {
            // A double holds seconds since 1970 to a quarter of a microsecond.
            Form::Decimal(unit_ns) if value.abs() * *unit_ns as f64 > 1e17 => {
                Some((value * (*unit_ns as f64 / 1e3)).round() * 1e3)
            }
            Form::Decimal(unit_ns) => Some((value * *unit_ns as f64).round()),
            Form::OfDay { time: OfDay::Number(unit_ns), day, .. } => {
                let ns = (value * *unit_ns as f64).round();
                (0.0..=DAY_NS as f64).contains(&ns).then_some(*day as f64 * DAY_NS as f64 + ns)
            }
            Form::Days(epoch) => {
                let stamp = clock::days(value, *epoch).map(|clock_ns| Stamp { clock_ns, ahead_s: None });
                return stamp.ok_or_else(|| self.expected()).and_then(|stamp| self.zone.moment(stamp));
            }
            _ => None,
        };
        let ns = ns.filter(|ns| ns.abs() < 9.2e18).ok_or_else(|| self.expected())? as i64;
        ns.checked_add(self.begin_ns).ok_or_else(|| self.expected())
    }

    /// What a time must be.
    pub fn expected(&self) -> String {
        match self.said.as_str() {
            "iso" => "a time as in 2024-05-10T00:00:00Z".into(),
            "seconds_of_day" => "seconds since midnight, 0 to 86400".into(),
            "milliseconds_of_day" => "milliseconds since midnight, 0 to 86400000".into(),
            "hours_of_day" => "hours since midnight, 0 to 24".into(),
            "day_of_year" => "a year and a day of it, as in 2024 131.5".into(),
            said => format!("a time as the mapping's `time.format` says: {said}"),
        }
    }

    /// What can be said of times only when all rows are there: rows that are counted, and days of rows that
    /// hold the time of day alone.
    pub fn settle(&self, source: &Source, rows: &mut Rows, notes: &mut Vec<String>) -> Result<(), Error> {
        let count = rows.lines.len();
        match &self.form {
            Form::Step(step_s) => {
                let at = |row: usize| self.begin_ns + (row as f64 * step_s * 1e9).round() as i64;
                rows.times_ns = (0..count).map(at).collect();
            }
            Form::None => rows.times_ns = (0..count as i64).collect(),
            Form::OfDay { named, .. } => {
                if *named {
                    name_day(source, rows, notes)?;
                } else {
                    // Each midnight begins the next day.
                    for midnight in midnights(&rows.times_ns) {
                        rows.times_ns[midnight..].iter_mut().for_each(|time| *time += DAY_NS);
                    }
                }
                // Clock times of known days to UTC.
                for (time, line) in rows.times_ns.iter_mut().zip(&rows.lines) {
                    let stamp = Stamp { clock_ns: *time, ahead_s: None };
                    *time = self.zone.moment(stamp).map_err(|expected| {
                        let shown = clock::text(*time);
                        source.in_line(*line, shown.trim_end_matches('Z'), expected)
                    })?;
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// Rows with which a day begins: midnight is where the time of day falls by more than half a day.
fn midnights(times_ns: &[i64]) -> Vec<usize> {
    (1..times_ns.len()).filter(|row| times_ns[row - 1] - times_ns[*row] > DAY_NS / 2).collect()
}

/// The day of the file's name is that of most rows: a log that begins at 23:59 began the day before.
fn name_day(source: &Source, rows: &mut Rows, notes: &mut Vec<String>) -> Result<(), Error> {
    match midnights(&rows.times_ns).as_slice() {
        [] => {}
        [midnight] => {
            let before = 2 * midnight < rows.times_ns.len();
            let (part, shift) =
                if before { (0..*midnight, -DAY_NS) } else { (*midnight..rows.times_ns.len(), DAY_NS) };
            let which = if before { "begins on the day before" } else { "goes on into the day after" };
            notes.push(format!("{which} the one in its name"));
            rows.times_ns[part].iter_mut().for_each(|time| *time += shift);
        }
        [_, second, ..] => {
            let line = u64::from(rows.lines[*second]);
            let expected =
                "the rows of one day; give a column with the date, or `start` in place of `date_in_name`";
            return Err(source.fault(Place::Line(line), "a second midnight in the file", expected));
        }
    }
    Ok(())
}

/// The date within the file's name: the first place where the pattern fits.
fn day_in_name(source: &Source, pattern: &str) -> Result<i64, Error> {
    let name = source.name.as_str();
    for (start, _) in name.char_indices() {
        let found = BrokenDownTime::parse_prefix(pattern, &name[start..]).ok();
        if let Some(date) = found.and_then(|(parts, _)| parts.to_date().ok()) {
            return Ok(days_of(date));
        }
    }
    let expected = format!("a date in its name as {pattern}, as the mapping's `time.date_in_name` says");
    Err(source.fault(Place::Whole, format!("the name {name:?}"), expected))
}

fn days_of(date: Date) -> i64 {
    clock::day(i64::from(date.year()), i64::from(date.month()), i64::from(date.day())).unwrap_or_default()
}

/// What the parts of a pattern say together.
fn stamp(parts: &BrokenDownTime) -> Option<Stamp> {
    let shown: DateTime = parts.to_datetime().ok().or_else(|| Some(parts.to_date().ok()?.at(0, 0, 0, 0)))?;
    let time = shown.time();
    let seconds = 3600 * i64::from(time.hour()) + 60 * i64::from(time.minute()) + i64::from(time.second());
    let clock_ns = days_of(shown.date()) * DAY_NS + seconds * SECOND_NS + i64::from(time.subsec_nanosecond());
    Some(Stamp { clock_ns, ahead_s: parts.offset().map(|offset| i64::from(offset.seconds())) })
}

/// `2024 131.5`: noon of 10 May 2024.
fn day_of_year(text: &[u8], point: u8) -> Option<Stamp> {
    let mut parts = text.split(|byte| *byte == b' ').filter(|part| !part.is_empty());
    let (year, of_year) = (clock::float(parts.next()?, point)?, clock::float(parts.next()?, point)?);
    let first = clock::day(year as i64, 1, 1)?;
    let fits = year.fract() == 0.0 && (1.0..367.0).contains(&of_year) && parts.next().is_none();
    let clock_ns = clock::days(of_year - 1.0, -(first as f64))?;
    fits.then_some(Stamp { clock_ns, ahead_s: None })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(format: &str, zone: Option<&str>, text: &str) -> Result<String, String> {
        let mapping =
            TimeMapping { format: format.into(), zone: zone.map(str::to_string), ..TimeMapping::default() };
        let times =
            Times::new(&Source::empty("x.csv"), Some(&mapping), '.').map_err(|error| error.to_string())?;
        times.read(text.as_bytes()).map(clock::text)
    }

    #[test]
    fn patterns_and_zones() {
        for (format, zone, text, moment) in [
            ("%d.%m.%Y %H:%M:%S", None, "01.09.2011 12:00:05", "2011-09-01T12:00:05Z"),
            ("%d.%m.%Y %H:%M:%S", Some("Europe/Vienna"), "01.09.2011 12:00:05", "2011-09-01T10:00:05Z"),
            ("%Y %j %H:%M:%S%.f", None, "2011 244 00:00:00.25", "2011-09-01T00:00:00.25Z"),
            ("%Y-%m-%dT%H:%M:%S%z", None, "2011-09-01T00:00:00+0200", "2011-08-31T22:00:00Z"),
            ("day_of_year", None, "2024 131.5", "2024-05-10T12:00:00Z"),
            ("unix_ms", None, "1565373905343.25", "2019-08-09T18:05:05.34325Z"),
            ("excel_days", Some("+02:00"), "45422.5", "2024-05-10T10:00:00Z"),
            ("%Y-%m-%d seconds_of_day", None, "2025-03-14 3661.25", "2025-03-14T01:01:01.25Z"),
            ("%Y %j seconds_of_day", Some("+01:00"), "2025 73 86400", "2025-03-14T23:00:00Z"),
            ("%Y%m%d hours_of_day", None, "20250314 1.5", "2025-03-14T01:30:00Z"),
            ("%m/%d/%Y %I:%M:%S %p", None, "3/14/2025 1:05:00 PM", "2025-03-14T13:05:00Z"),
            ("%m/%d/%Y %I:%M:%S %p", None, "12/4/2025 12:05:00 AM", "2025-12-04T00:05:00Z"),
        ] {
            assert_eq!(read(format, zone, text).as_deref(), Ok(moment), "{format}");
        }
        assert!(read("iso", None, "1.9.2011").expect_err("no ISO").contains("2024-05-10T00:00:00Z"));
        assert!(read("day_of_year", None, "2024 0.5").is_err());
        assert!(read("%Y-%m-%d seconds_of_day", None, "2025-03-14 86401").is_err());
        assert!(read("%Y-%m-%d seconds_of_day", None, "2025-03-14").is_err());
    }

    #[test]
    fn from_a_day_that_is_stated_over_two_midnights() {
        for (format, texts) in [
            ("seconds_of_day", "43200 86399.5 0.5 60000 1"),
            ("%H:%M:%S%.f", "12:00:00 23:59:59.5 00:00:00.5 16:40:00 00:00:01"),
        ] {
            let start = Some("2025-03-14T00:00:00Z".into());
            let mapping = TimeMapping { format: format.into(), start, ..TimeMapping::default() };
            let (times_ns, _) = settled("x.csv", &mapping, texts);
            let days: Vec<i64> = times_ns.iter().map(|time| time / DAY_NS - 20_161).collect();
            assert_eq!(days, [0, 0, 1, 1, 2], "{format}");
        }
    }

    /// Times of rows of a file of that name, in UTC, and notes.
    fn settled(name: &str, mapping: &TimeMapping, texts: &str) -> (Vec<i64>, Vec<String>) {
        let (source, mut notes) = (Source::empty(name), Vec::new());
        let times = Times::new(&source, Some(mapping), '.').expect("times");
        let read = texts.split(' ').map(|text| times.read(text.as_bytes()).expect(text));
        let mut rows = Rows { lines: (1..=5).collect(), times_ns: read.collect(), ..Rows::default() };
        times.settle(&source, &mut rows, &mut notes).expect("settled");
        assert_eq!(times.clock(), Clock::Utc);
        (rows.times_ns, notes)
    }

    #[test]
    fn a_day_in_the_name_and_a_log_that_begins_before_it() {
        let mapping = TimeMapping {
            format: "%H:%M:%S".into(),
            date_in_name: Some("%b%d%y".into()),
            ..TimeMapping::default()
        };
        let (times_ns, notes) = settled("x-SEP0111.txt", &mapping, "23:59:50 00:00:00 00:00:10 00:00:20");
        assert_eq!(clock::text(times_ns[0]), "2011-08-31T23:59:50Z");
        assert_eq!(clock::text(times_ns[3]), "2011-09-01T00:00:20Z");
        assert_eq!(notes.len(), 1);
    }
}
