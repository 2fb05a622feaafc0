//! Where the time of each row stands, and how it is written.

use jiff::fmt::strtime::{self, BrokenDownTime};

use super::content;
use super::names::{is_among, plain};
use super::open::Guess;
use super::sample::{Cells, Sample};
use crate::mapping::TimeMapping;

/// Ways to write a date that ISO 8601 does not know.
const DATES: [&str; 8] =
    ["%d.%m.%Y", "%d.%m.%y", "%d/%m/%Y", "%m/%d/%Y", "%d-%m-%Y", "%d-%b-%Y", "%Y%m%d", "%Y-%m-%d"];
const TIMES: [&str; 5] = ["%H:%M:%S%.f", "%H:%M", "%H%M%S", "%I:%M:%S %p", "%I:%M %p"];
const IN_NAMES: [&str; 5] = ["%Y-%m-%d", "%Y_%m_%d", "%Y%m%d", "%b%d%y", "%d%m%Y"];
/// Names of columns that hold a time, as letters and digits in lower case.
const NAMES: &str = "time t ts timestamp datetime date utc epoch unix unixs unixtime times seconds secondselapsed elapsed \
                     sec millis timems timens";
const YEAR: &str = "year yyyy";
const DAY_OF_YEAR: &str = "doy dayofyear yday";
/// Names of columns that count from midnight, by how.
const SINCE_MIDNIGHT: [(&str, &str); 3] = [
    ("seconds_of_day", "sod secofday secondofday secondsofday secday secondssincemidnight"),
    ("milliseconds_of_day", "msofday millisofday"),
    ("hours_of_day", "hourofday"),
];

/// Guesses the time; gives the columns that it takes.
pub fn guess(sample: &Sample, file_name: &str, guess: &mut Guess) -> Vec<usize> {
    let ways = [iso, moment, one_pattern, since_midnight, number, two_columns, of_day, by_content];
    for way in ways {
        if let Some((columns, mut mapping)) = way(sample, file_name, guess) {
            mapping.columns = columns.iter().map(|column| sample.from[*column].clone()).collect();
            guess.mapping.time = Some(mapping);
            return columns;
        }
    }
    let unread = columns_of(sample, Cells::Text).find(|column| {
        let name = plain(&sample.names[*column]);
        is_among(&name, NAMES) || name.contains("time") || name.contains("date")
    });
    match unread {
        Some(column) => guess.doubts.push(format!("how the times in {:?} are written", sample.names[column])),
        None => guess.notes.push("no column of times was found: rows count in their order".into()),
    }
    Vec::new()
}

type GuessedTime = Option<(Vec<usize>, TimeMapping)>;

fn of(format: &str) -> TimeMapping {
    TimeMapping { format: format.into(), ..TimeMapping::default() }
}

/// Local times, whose zone nobody states.
fn without_zone(sample: &Sample, column: usize, mut mapping: TimeMapping, guess: &mut Guess) -> TimeMapping {
    mapping.zone = Some("UTC".into());
    if !plain(&sample.names[column]).contains("utc") {
        guess.notes.push(
            "times are taken as UTC; where the clock was another, change `time.zone` in a mapping".into(),
        );
    }
    mapping
}

fn columns_of(sample: &Sample, kind: Cells) -> impl Iterator<Item = usize> {
    (0..sample.kinds.len()).filter(move |column| sample.kinds[*column] == kind)
}

/// The first column with one of these names.
fn named(sample: &Sample, names: &str) -> Option<usize> {
    sample.names.iter().position(|name| is_among(&plain(name), names))
}

fn year_and_day(sample: &Sample) -> Option<[usize; 2]> {
    Some([named(sample, YEAR)?, named(sample, DAY_OF_YEAR)?])
}

/// The first column of text, or of a name that speaks of a date, with dates.
fn dates(sample: &Sample) -> Option<usize> {
    let may = |column: &usize| {
        sample.kinds[*column] != Cells::Numbers || plain(&sample.names[*column]).contains("date")
    };
    (0..sample.kinds.len()).filter(may).find(|column| !fitting(&sample.cells[*column], &DATES).is_empty())
}

fn there(sample: &Sample, column: usize) -> impl Iterator<Item = &str> {
    sample.cells[column].iter().map(|cell| cell.trim()).filter(|cell| !cell.is_empty())
}

fn iso(sample: &Sample, _: &str, guess: &mut Guess) -> GuessedTime {
    let column =
        columns_of(sample, Cells::Iso).find(|column| there(sample, *column).any(|cell| cell.len() > 10))?;
    let zoned = |cell: &str| crate::clock::iso(cell.as_bytes()).is_some_and(|stamp| stamp.ahead_s.is_some());
    let most = there(sample, column).filter(|cell| zoned(cell)).count() * 2 > there(sample, column).count();
    let mapping = if most { of("iso") } else { without_zone(sample, column, of("iso"), guess) };
    Some((vec![column], mapping))
}

fn moment(sample: &Sample, _: &str, _: &mut Guess) -> GuessedTime {
    // Parquet's are read as seconds; a CDF's are moments whatever is said.
    columns_of(sample, Cells::Moments).next().map(|column| (vec![column], of("unix_s")))
}

/// Patterns that most cells fit.
fn fitting<P: AsRef<str> + ToString>(cells: &[String], patterns: &[P]) -> Vec<String> {
    let there: Vec<&str> = cells.iter().map(|cell| cell.trim()).filter(|cell| !cell.is_empty()).collect();
    let fits = |pattern: &&P| {
        2 * there.iter().filter(|cell| strtime::parse(pattern.as_ref(), cell).is_ok()).count() > there.len()
    };
    patterns.iter().filter(fits).map(P::to_string).collect()
}

/// The pattern of the times of day in a column.
fn clock(sample: &Sample, column: usize) -> Option<String> {
    fitting(&sample.cells[column], &TIMES).into_iter().next()
}

/// One of the patterns, `?` with a doubt where a day cannot be told from a month.
fn chosen(fitting: Vec<String>, name: &str, guess: &mut Guess) -> Option<String> {
    if fitting.iter().any(|pattern| pattern.contains("%d/%m"))
        && fitting.iter().any(|pattern| pattern.contains("%m/%d"))
    {
        let doubt = format!("in {name}, which is the day and which the month: {}", fitting.join(" or "));
        guess.doubts.push(doubt);
        return Some("?".into());
    }
    fitting.into_iter().next()
}

fn one_pattern(sample: &Sample, _: &str, guess: &mut Guess) -> GuessedTime {
    let joined = |date: &&str| TIMES.map(|time| [format!("{date} {time}"), format!("{date}T{time}")]);
    let patterns: Vec<String> = DATES.iter().flat_map(joined).flatten().collect();
    columns_of(sample, Cells::Text).find_map(|column| {
        let pattern = chosen(fitting(&sample.cells[column], &patterns), &sample.names[column], guess)?;
        Some((vec![column], without_zone(sample, column, of(&pattern), guess)))
    })
}

fn within(values: &[f64], low: f64, high: f64) -> bool {
    !values.is_empty() && values.iter().all(|value| *value >= low && *value < high)
}

/// A count since 1970 that is a moment from 1990 to 2060.
fn since_1970(values: &[f64]) -> Option<&'static str> {
    let units = [("unix_s", 1.0), ("unix_ms", 1e3), ("unix_us", 1e6), ("unix_ns", 1e9)];
    let found = units.into_iter().find(|(_, unit)| within(values, 6.3e8 * unit, 2.84e9 * unit));
    found.map(|(format, _)| format)
}

fn number(sample: &Sample, _: &str, guess: &mut Guess) -> GuessedTime {
    let nameless = sample.names.iter().all(String::is_empty);
    let named = |column: &usize| {
        let name = plain(&sample.names[*column]);
        is_among(&name, NAMES) || name.starts_with("unix") || (nameless && *column == 0)
    };
    let format = |column: usize| {
        let values = sample.numbers(column);
        since_1970(&values)
            .or_else(|| within(&values, 30_000.0, 60_000.0).then_some("excel_days"))
            .or_else(|| within(&values, 720_000.0, 750_000.0).then_some("matlab_days"))
    };
    let candidates: Vec<usize> = columns_of(sample, Cells::Numbers).filter(named).collect();
    let unix = candidates.iter().find_map(|column| Some((*column, format(*column)?)));
    if let Some((column, format)) = unix {
        let dated = plain(&sample.names[column]).contains("date") || format.starts_with("unix");
        if !dated {
            let doubt = format!("whether {:?} counts days ({format}) or seconds", sample.names[column]);
            guess.doubts.push(doubt);
        }
        return Some((vec![column], of(format)));
    }
    let column = *candidates.first().filter(|_| !nameless)?;
    let name = plain(&sample.names[column]);
    let format = if name.contains("milli") || name.ends_with("ms") { "milliseconds" } else { "seconds" };
    Some((vec![column], of(format)))
}

/// A number since midnight, with the day in another column or in the file's name.
fn since_midnight(sample: &Sample, file_name: &str, guess: &mut Guess) -> GuessedTime {
    let (column, format) = columns_of(sample, Cells::Numbers).find_map(|column| {
        let name = plain(&sample.names[column]);
        let (format, _) = SINCE_MIDNIGHT.iter().find(|(_, names)| is_among(&name, names))?;
        Some((column, *format))
    })?;
    let (columns, mapping) = match day(sample, guess) {
        Some((mut columns, pattern)) => {
            columns.push(column);
            (columns, of(&if pattern == "?" { pattern } else { format!("{pattern} {format}") }))
        }
        None => (vec![column], TimeMapping { date_in_name: in_name(file_name, guess), ..of(format) }),
    };
    Some((columns, without_zone(sample, column, mapping, guess)))
}

/// The columns of the date and its pattern: a date, or year and day of the year.
fn day(sample: &Sample, guess: &mut Guess) -> Option<(Vec<usize>, String)> {
    if let Some(columns) = year_and_day(sample) {
        return Some((columns.into(), "%Y %j".into()));
    }
    let date = dates(sample)?;
    Some((vec![date], chosen(fitting(&sample.cells[date], &DATES), &sample.names[date], guess)?))
}

/// Numbers that rise evenly, whatever their column is called.
fn by_content(sample: &Sample, _: &str, guess: &mut Guess) -> GuessedTime {
    let column =
        columns_of(sample, Cells::Numbers).find(|column| content::rises_evenly(&sample.numbers(*column)))?;
    let format = since_1970(&sample.numbers(column)).unwrap_or("seconds");
    let name = match sample.names[column].as_str() {
        "" => format!("column {}", column + 1),
        name => format!("{name:?}"),
    };
    let doubt = format!("whether {name}, which rises evenly, is the time ({format}), and in which unit");
    guess.doubts.push(doubt);
    Some((vec![column], of(format)))
}

/// A date and a time of day in columns of their own, or year and day of the year.
fn two_columns(sample: &Sample, _: &str, guess: &mut Guess) -> GuessedTime {
    if let Some([year, day]) = year_and_day(sample) {
        let decimals = there(sample, day).any(|cell| cell.contains(sample.notation.mapping.decimal));
        let time = columns_of(sample, Cells::Text).find_map(|column| Some((column, clock(sample, column)?)));
        let (columns, mapping) = match time.filter(|_| !decimals) {
            None => (vec![year, day], of("day_of_year")),
            Some((time, pattern)) => (vec![year, day, time], of(&format!("%Y %j {pattern}"))),
        };
        return Some((columns, without_zone(sample, year, mapping, guess)));
    }
    let date = dates(sample)?;
    let may = |column: &usize| {
        let named = || plain(&sample.names[*column]).contains("time");
        *column != date && (sample.kinds[*column] == Cells::Text || named())
    };
    let mut times = (0..sample.kinds.len()).filter(may);
    let (time, clock) = times.find_map(|column| Some((column, clock(sample, column)?)))?;
    let date_pattern = chosen(fitting(&sample.cells[date], &DATES), &sample.names[date], guess)?;
    let pattern = if date_pattern == "?" { date_pattern } else { format!("{date_pattern} {clock}") };
    Some((vec![date, time], without_zone(sample, date, of(&pattern), guess)))
}

/// The time of day alone; the date must be in the file's name.
fn of_day(sample: &Sample, file_name: &str, guess: &mut Guess) -> GuessedTime {
    let one = columns_of(sample, Cells::Text).find_map(|column| Some((vec![column], clock(sample, column)?)));
    let two = || Some((vec![named(sample, "hh hour h")?, named(sample, "mm minute min")?], "%H %M".into()));
    let (columns, pattern) = one.or_else(two)?;
    let mapping = TimeMapping { date_in_name: in_name(file_name, guess), ..of(&pattern) };
    let first = columns[0];
    Some((columns, without_zone(sample, first, mapping, guess)))
}

/// The pattern of a date in the file's name; a doubt where there is none.
fn in_name(file_name: &str, guess: &mut Guess) -> Option<String> {
    let in_name: Option<&str> = IN_NAMES.into_iter().find(|pattern| {
        file_name.char_indices().any(|(start, _)| {
            let found = BrokenDownTime::parse_prefix(pattern, &file_name[start..]).ok();
            found.is_some_and(|(parts, _)| {
                parts.to_date().is_ok_and(|date| (1980..2060).contains(&date.year()))
            })
        })
    });
    if in_name.is_none() {
        guess.doubts.push(
            "the date: rows hold the time of day alone, and the file's name shows none (`time.date_in_name`)"
                .into(),
        );
    }
    in_name.map(str::to_string)
}
