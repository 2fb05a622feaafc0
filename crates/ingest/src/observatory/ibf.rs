//! Baselines of a variometer over a year (IBF 1.x and 2.00): absolute − variometer, observed on some days, adopted
//! for each. A row a day, at noon; where there are several observations, their mean.
//!
//! 2.00: `HDZF 20946 48550 FLX 2024`, then nT and minutes of arc with two decimals, four to a day. 1.x: no mean of F
//! in the header, and three to a day, in tenths.

use common::number::counted;
use indexmap::IndexMap;
use serde_json::Value;
use std::collections::BTreeMap;
use tables::Place;

use super::elements;
use crate::Error;
use crate::clock::{self, DAY_NS};
use crate::fill;
use crate::piece::Piece;
use crate::text::{Source, decoded, lines, quoted};

/// Beyond the digits that a column has.
const MOST: f64 = 1e7;

pub struct Header {
    letters: Vec<char>,
    /// Annual means of H and, in 2.00, of F, nT.
    means: Vec<f64>,
    station: String,
    year: i64,
}

/// A day of the year: its first line, and baselines in the order of [`Header::names`].
#[derive(Default)]
struct Day {
    line: u32,
    observed: Vec<Vec<f64>>,
    /// With the difference |vector| − scalar at the end, where there is one.
    adopted: Option<Vec<f64>>,
}

impl Header {
    /// A line, where it is such a header.
    pub fn of(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [components, means @ .., station, year] = words.as_slice() else { return None };
        let known = ["XYZ", "HDZ", "DIF", "UVZ", "DHZ"].iter().any(|known| components.starts_with(known));
        let is_station = station.len() == 3 && station.starts_with(|first: char| first.is_ascii_alphabetic());
        let means: Vec<f64> = means.iter().map(number).collect::<Option<_>>()?;
        let year = year.parse().ok().filter(|year| (1800..2261).contains(year))?;
        let letters = elements(components.get(..3)?)?;
        let fits = known && components.len() <= 4 && is_station && (1..=2).contains(&means.len());
        fits.then_some(Header { letters, means, station: station.to_string(), year })
    }

    fn is_old(&self) -> bool {
        self.means.len() == 1
    }

    /// Names of a day's baselines without their kind, in the document's units.
    fn names(&self) -> Vec<String> {
        let name = |letter: &char| match letter {
            'D' | 'I' => format!("{}_deg", letter.to_ascii_lowercase()),
            letter => format!("{}_nt", letter.to_ascii_lowercase()),
        };
        let scalar = (!self.is_old()).then(|| "scalar_nt".to_string());
        self.letters.iter().map(name).chain(scalar).collect()
    }

    /// Values in the document's units: 99999 is missing, 88888 not observed, 999 and 888 of a difference.
    fn values(&self, stored: &[f64], names: &[String]) -> Vec<f64> {
        let per_unit = if self.is_old() { 10.0 } else { 1.0 };
        let mut values: Vec<f64> = stored.iter().map(|stored| stored / per_unit).collect();
        fill::without(&mut values, true);
        for (index, value) in values.iter_mut().enumerate() {
            match names.get(index) {
                Some(name) if name.ends_with("_deg") => *value /= 60.0,
                None if matches!(value.abs().trunc(), 999.0 | 888.0) => *value = f64::NAN,
                _ => {}
            }
        }
        values
    }
}

pub fn read(source: &Source) -> Result<Piece, Error> {
    let mut rows = lines(&source.bytes).filter(|(_, line)| !line.trim_ascii().is_empty());
    let header =
        rows.next().and_then(|(_, line)| Header::of(&decoded(line))).ok_or_else(|| source.no_row())?;
    let (names, mut piece) = (header.names(), Piece::of(source, "IBF"));
    let start = |year: i64| clock::day(year, 1, 1).ok_or_else(|| source.no_row());
    let (first, next) = (start(header.year)?, start(header.year + 1)?);
    let (mut days, mut steps, mut comments) = (BTreeMap::<i64, Day>::new(), Vec::new(), Vec::new());
    let mut section = 0;
    for (line_number, line) in rows {
        let text = decoded(line);
        let fault = |found: String, expected: String| Err(source.in_line(line_number, found, expected));
        let text = text.trim();
        if section == 2 {
            comments.push(Value::from(text));
            continue;
        } else if text == "*" {
            section += 1;
            continue;
        }
        let mut words: Vec<&str> = text.split_whitespace().collect();
        let adopted = section == 1;
        let mark = words.pop_if(|word| adopted && matches!(*word, "c" | "d" | "C" | "D"));
        let numbers: Option<Vec<f64>> = words.iter().map(number).collect();
        let most = names.len() + 1 + usize::from(adopted);
        let fits = |count: usize| count == most || (adopted && header.is_old() && count + 1 == most);
        let is_marked = !adopted || header.is_old() || mark.is_some();
        let numbers = numbers.filter(|numbers| fits(numbers.len()) && is_marked).unwrap_or_default();
        let Some((of_year, stored)) = numbers.split_first() else {
            let (kind, more) = match (adopted, header.is_old()) {
                (false, _) => ("observed", ""),
                (true, true) => ("adopted", ", Delta F"),
                (true, false) => ("adopted", ", Delta F, and c or d"),
            };
            let count = names.len();
            let expected =
                format!("the day of the year, {count} {kind} baselines{more} (IBF); was the file cut?");
            return fault(quoted(line), expected);
        };
        let day = first - 1 + *of_year as i64;
        if of_year.fract() != 0.0 || !(first..next).contains(&day) {
            let expected = format!("a day of {}, 1 to {}", header.year, next - first);
            return fault(format!("day {of_year}"), expected);
        }
        let entry = days.entry(day).or_insert_with(|| Day { line: line_number, ..Day::default() });
        let values = header.values(stored, &names);
        if !adopted {
            entry.observed.push(values);
        } else if entry.adopted.replace(values).is_some() {
            return fault(format!("day {of_year} twice"), "adopted baselines once for each day".into());
        }
        if mark.is_some_and(|mark| mark.eq_ignore_ascii_case("d")) {
            steps.push(Value::from(&clock::text(day * DAY_NS)[..10]));
        }
    }
    if section < 2 {
        let found = format!("{section} of two lines with *, which end observed and adopted baselines (IBF)");
        return Err(source.fault(Place::Whole, found, "both; was the file cut?"));
    }
    let several = days.values().filter(|day| day.observed.len() > 1).count();
    if several > 0 {
        piece.notes.push(format!("{} with several observations: their mean", counted(several, "day")));
    }
    piece.times_ns = days.keys().map(|day| day * DAY_NS + DAY_NS / 2).collect();
    piece.lines = days.values().map(|day| day.line).collect();
    piece.columns = columns(&names, &days);
    if piece.columns.is_empty() {
        return Err(source.fault(Place::Whole, "no baseline that is not missing", "one on one day at least"));
    }
    piece.header.insert("components".into(), header.letters.iter().collect::<String>().into());
    for (name, mean) in ["annual_mean_h_nt", "annual_mean_f_nt"].into_iter().zip(&header.means) {
        piece.header.insert(name.into(), (*mean).into());
    }
    let lists =
        [("discontinuities", steps), ("comments", comments)].into_iter().filter(|(_, list)| !list.is_empty());
    piece.header.extend(lists.map(|(name, list)| (name.to_string(), list.into())));
    piece.station = Some(header.station);
    Ok(piece)
}

fn number(word: &&str) -> Option<f64> {
    word.parse().ok().filter(|number: &f64| number.abs() < MOST)
}

/// The columns that have a value.
fn columns(names: &[String], days: &BTreeMap<i64, Day>) -> IndexMap<String, Vec<f64>> {
    let observed = |day: &Day, index: usize| {
        let there: Vec<f64> =
            day.observed.iter().map(|values| values[index]).filter(|value| !value.is_nan()).collect();
        // Of none it is 0/0, which is NaN.
        there.iter().sum::<f64>() / there.len() as f64
    };
    let adopted = |day: &Day, index: usize| {
        day.adopted.as_ref().and_then(|values| values.get(index)).copied().unwrap_or(f64::NAN)
    };
    let mut columns = IndexMap::new();
    for (index, name) in names.iter().enumerate() {
        let values = days.values().map(|day| observed(day, index)).collect();
        columns.insert(format!("observed_baseline_{name}"), values);
    }
    let names = names.iter().map(|name| format!("adopted_baseline_{name}")).chain(["delta_f_nt".into()]);
    for (index, name) in names.enumerate() {
        columns.insert(name, days.values().map(|day| adopted(day, index)).collect::<Vec<f64>>());
    }
    columns.retain(|_, values: &mut Vec<f64>| values.iter().any(|value| !value.is_nan()));
    columns
}
