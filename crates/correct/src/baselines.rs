//! The baselines of a document as IBFV2.00, INTERMAGNET's yearly baseline file (Technical Reference Manual, appendix on data
//! formats; <https://tech-man.intermagnet.org/stable/appendices/dataformats.html>): those observed, those adopted for each
//! day, comments. Lines of a fixed length that end with CrLf.

use common::time::Start;
use common::{AbsoluteSet, Document, Error, Quantity, Recording};
use estimate::stats::mean;
use jiff::Zoned;
use jiff::civil::date;
use jiff::tz::TimeZone;

use crate::Frame;
use crate::formats::{calendar, station_code};
use crate::noise::DAY_S;
use crate::variometer::{DELTA_F, adopted, is_by_baselines};

/// What is missing, and what is never observed: a component, nT; Delta F.
const CODES: [[f64; 2]; 2] = [[99_999.0, 88_888.0], [999.0, 888.0]];
/// Characters of a line of comments at most.
const COMMENT: usize = 53;

/// IBFV2.00 of the year in which most measurements are: observed values, and those adopted at noon of every day.
/// Errors: a document without adopted baselines; what the format cannot hold.
pub fn ibf(document: Document, station: &str) -> Result<String, Error> {
    // Daily means of ΔF are those of the variometer's readings, where they are at hand.
    let is_there = |one: &Recording| crate::is_corrected(one) && is_by_baselines(&document, one);
    let is_there = document.recordings.iter().any(is_there);
    let document = &if is_there { crate::run(document, Frame::Geo)? } else { document };
    let found = adopted(document).zip(document.calibration.as_ref().and_then(|all| all.absolute.as_ref()));
    let Some(((components, baselines), absolute)) = found else {
        let expected = "baselines of a variometer, which absolute adopts";
        return Err(Error::document("calibration.absolute.adopted", "none", expected));
    };
    let station = station_code(station, 3)?;
    let moments: Vec<(&AbsoluteSet, Zoned)> = (absolute.sets.iter())
        .filter_map(|set| Some((set, calendar((Start::parse(&set.time)?.unix_s * 1e9) as i64))))
        .collect();
    let count = |year: i16| moments.iter().filter(|(_, moment)| moment.year() == year).count();
    let year = moments.iter().map(|(_, moment)| moment.year()).max_by_key(|year| (count(*year), -year));
    let year = year.unwrap_or_default();
    if year < 1000 {
        return Err(refused(&format!("the year {year}"), "one of four digits"));
    }
    let of_year = moments.iter().filter(|(_, moment)| moment.year() == year);
    let (keys, pillar) = (components.keys(), baselines.pillar_difference_nt);
    // Absolute − recorded, nT, or degrees of D: the three components and the scalar magnetometer.
    let value = |(set, moment): &(&AbsoluteSet, Zoned)| {
        let [x, y, z] = keys.map(|key| set.baseline.get(key).map_or(f64::NAN, Quantity::value));
        (moment.day_of_year(), [x, y, z, pillar])
    };
    let mut observed: Vec<(i16, [f64; 4])> = of_year.clone().map(value).collect();
    observed.sort_by_key(|(day, _)| *day);
    let origin_s = Start::parse(&baselines.start).map_or(0.0, |origin| origin.unix_s);
    let first =
        date(year, 1, 1).to_zoned(TimeZone::UTC).map_or(0.0, |day| day.timestamp().as_second() as f64);
    let days = date(year, 1, 1).days_in_year();
    let steps: Vec<f64> = (baselines.components.values())
        .flat_map(|one| &one.steps)
        .filter_map(|step| Some(Start::parse(&step.time)?.unix_s))
        .collect();
    // Of each day the values, ΔF, and whether something was changed since the day before, so that baselines have a step.
    let day = |(day, delta_f_nt): (usize, f64)| {
        let noon_s = first + (day as f64 + 0.5) * DAY_S;
        let [x, y, z] =
            keys.map(|key| baselines.at(key, noon_s - origin_s).map_or(f64::NAN, |[value, _]| value));
        let scalar = if x.is_nan() { f64::NAN } else { pillar };
        ([x, y, z, scalar], delta_f_nt, steps.iter().any(|step| (noon_s - DAY_S..noon_s).contains(step)))
    };
    let adopted: Vec<([f64; 4], f64, bool)> =
        delta_f(document, first, days as usize).into_iter().enumerate().map(day).collect();
    let mean_of = |of: fn(&AbsoluteSet) -> Option<&Quantity>| {
        let all: Vec<f64> = of_year.clone().filter_map(|(set, _)| Some(of(set)?.value())).collect();
        number(mean(&all), true, CODES[0])
    };
    let courses = baselines.components.iter().map(|(key, one)| {
        let unit = if key.ends_with("_deg") { "deg" } else { "nT" };
        format!("{key}: {}; excess scatter {:.4} {unit}.", one.trend, one.scatter_std)
    });
    let how = "Adopted baselines: model average weighted by Bayesian evidence. Annual means are those of the measurements.";
    let said = [how.to_string()].into_iter().chain(courses).flat_map(|comment| wrapped(&comment));
    let said: Vec<String> = said.collect();
    if !said.iter().all(|line| line.is_ascii()) {
        let expected = "a comment in ASCII on how the baselines were adopted, required by IBF";
        return Err(refused("no comment, or one that is not ASCII", expected));
    }
    // A component without any value counts as not observed.
    let all = || observed.iter().map(|(_, values)| values).chain(adopted.iter().map(|(values, ..)| values));
    let is_there = [0, 1, 2, 3].map(|column| all().any(|values| values[column].is_finite()));
    let has_delta = adopted.iter().any(|(_, delta_f_nt, _)| delta_f_nt.is_finite());
    let letters = if components.name() == "hez" { "HDZF" } else { "XYZF" };
    let line = |day: i16, values: &[f64; 4]| -> Result<String, Error> {
        let mut text = format!("{day:03}");
        for ((value, letter), is_there) in values.iter().zip(letters.chars()).zip(is_there) {
            let stored = if letter == 'D' { 60.0 * value } else { *value };
            text += &format!(" {:9.2}", number(stored, is_there, CODES[0])?);
        }
        Ok(text)
    };
    let (h, f) = (mean_of(|set| set.h_nt.as_ref())?, mean_of(|set| set.f_nt.as_ref())?);
    let mut lines = vec![format!("{letters} {h:5.0} {f:5.0} {station} {year}")];
    for (day, values) in &observed {
        lines.push(line(*day, values)?);
    }
    lines.push("*".into());
    for (day, (values, delta_f_nt, is_step)) in (1..).zip(&adopted) {
        let (delta, mark) = (number(*delta_f_nt, has_delta, CODES[1])?, if *is_step { 'd' } else { 'c' });
        lines.push(format!("{} {delta:7.2} {mark}", line(day, values)?));
    }
    lines.extend(["*".to_string(), "Comments:".into()].into_iter().chain(said));
    Ok(lines.iter().map(|line| format!("{line}\r\n")).collect())
}

/// Mean ΔF of each day, of the recordings that were corrected.
fn delta_f(document: &Document, first_s: f64, days: usize) -> Vec<f64> {
    let mut sums = vec![[0.0; 2]; days];
    let of = |one: &Recording| {
        Some((one.start()?.unix_s, one.column("time_s")?.to_vec(), one.column(DELTA_F)?.to_vec()))
    };
    for (start, times, values) in document.recordings.iter().filter_map(of) {
        for (time, value) in times.iter().zip(values).filter(|(_, value)| value.is_finite()) {
            let day = ((start + time - first_s) / DAY_S).floor();
            if let Some(sum) = sums.get_mut(day as usize).filter(|_| day >= 0.0) {
                *sum = [sum[0] + value, sum[1] + 1.0];
            }
        }
    }
    sums.into_iter().map(|[sum, count]| sum / count).collect()
}

fn refused(found: &str, expected: &str) -> Error {
    Error::Request(format!("found {found}; expected {expected}"))
}

/// A number as the file has it, or the code of a missing or unobserved one.
fn number(value: f64, is_there: bool, [missing, not_observed]: [f64; 2]) -> Result<f64, Error> {
    match value.is_finite() {
        true if value.abs() < not_observed - 0.5 => Ok(value),
        true => Err(refused(&value.to_string(), &format!("less than {not_observed}, a code of IBF"))),
        false => Ok(if is_there { missing } else { not_observed }),
    }
}

fn wrapped(text: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let letters: Vec<Vec<char>> = text.split_whitespace().map(|word| word.chars().collect()).collect();
    for word in letters.iter().flat_map(|word| word.chunks(COMMENT)).map(String::from_iter) {
        match lines.last_mut() {
            Some(line) if line.len() + 1 + word.len() <= COMMENT => *line += &format!(" {word}"),
            _ => lines.push(word),
        }
    }
    lines
}
