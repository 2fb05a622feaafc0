//! Files of one series, joined in the order of time; where they overlap and where they leave gaps.

use indexmap::IndexMap;
use serde::Serialize;
use tables::{Place, fault};

use crate::clock::{self, Clock, SECOND_NS};
use crate::piece::Piece;
use crate::{Error, Keep};

const LISTED: usize = 20;

#[derive(Debug)]
pub struct Series {
    pub clock: Clock,
    pub times_ns: Vec<i64>,
    pub columns: IndexMap<String, Vec<f64>>,
    /// Duplicate rows that were merged.
    pub merged: usize,
    /// Rows in which files disagree, where one of them was chosen.
    pub disagreeing: usize,
    /// Rows that were brought into the order of time.
    pub sorted: usize,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Gaps {
    pub count: usize,
    /// Rows that would fill them.
    pub missing_rows: u64,
    /// The longest, in the order of time.
    pub longest: Vec<Gap>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gap {
    pub after_s: f64,
    /// From that row to the next, s.
    pub seconds: f64,
}

/// The step of rising times that is the same throughout, ns.
pub fn even_step_ns(times_ns: &[i64]) -> Option<i64> {
    let step_ns = times_ns.get(1)? - times_ns.first()?;
    (step_ns > 0 && times_ns.windows(2).all(|pair| pair[1] - pair[0] == step_ns)).then_some(step_ns)
}

/// The usual step of rising times, s: the median, or where they were printed to the millisecond or
/// microsecond and are even but for that, the step that they were printed of (62.5 ms, not 62 or 63); None
/// for fewer than two rows.
pub fn step_s(times_ns: &[i64]) -> Option<f64> {
    if let Some(step_ns) = even_step_ns(times_ns) {
        return Some(step_ns as f64 / SECOND_NS as f64);
    }
    let mut steps: Vec<i64> =
        times_ns.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0).collect();
    let middle = steps.len().checked_sub(1)? / 2;
    let (_, step, _) = steps.select_nth_unstable(middle);
    let step = *step;
    Some(printed(times_ns, &steps, step).unwrap_or(step as f64) / SECOND_NS as f64)
}

/// The step, ns, of times that are even but for the last digit in which they were printed: the mean between
/// gaps, with as few digits as say it.
fn printed(times_ns: &[i64], steps: &[i64], usual: i64) -> Option<f64> {
    let first = times_ns[0];
    let unit =
        [1_000_000, 1000].into_iter().find(|unit| times_ns.iter().all(|time| (time - first) % unit == 0))?;
    let near = || steps.iter().filter(|step| 2 * **step < 3 * usual);
    if 10 * unit > usual || near().any(|step| (step - usual).abs() > unit) {
        return None;
    }
    let (sum, count) = near().fold((0, 0_i64), |(sum, count), step| (sum + step, count + 1));
    let (mean, off) = (sum as f64 / count as f64, 2.0 * unit as f64 / count as f64);
    (1..=9_i32).find_map(|digits| {
        let power = 10_f64.powi(mean.log10().floor() as i32 + 1 - digits);
        Some((mean / power).round() * power).filter(|rounded| (rounded - mean).abs() <= off)
    })
}

/// Steps of more than one and a half times the usual one.
pub fn gaps(times_ns: &[i64], first_ns: i64, step_s: f64) -> Gaps {
    let mut gaps = Gaps::default();
    let mut all: Vec<Gap> = Vec::new();
    let usual_ns = (1.5 * step_s * SECOND_NS as f64) as i64;
    for pair in times_ns.windows(2) {
        if pair[1] - pair[0] > usual_ns {
            let seconds = (pair[1] - pair[0]) as f64 / SECOND_NS as f64;
            gaps.count += 1;
            gaps.missing_rows += (seconds / step_s).round() as u64 - 1;
            all.push(Gap { after_s: (pair[0] - first_ns) as f64 / SECOND_NS as f64, seconds });
        }
    }
    all.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    all.truncate(LISTED);
    all.sort_by(|a, b| a.after_s.total_cmp(&b.after_s));
    gaps.longest = all;
    gaps
}

/// Joins files in the order of time. Errors: files of different stations or clocks; times that fall within a
/// file (unless `sort`); rows of one time that disagree (unless `keep` says which counts), each with files
/// and lines.
pub fn join(mut pieces: Vec<Piece>, keep: Option<Keep>, sort: bool) -> Result<(Series, Vec<Piece>), Error> {
    check_alike(&pieces)?;
    let mut sorted = 0;
    for piece in &pieces {
        sorted += falling(piece, sort)?;
    }
    // Stable: of files that begin together, the one that was given first comes first.
    pieces.sort_by_key(|piece| piece.times_ns.first().copied());
    let names: IndexMap<String, ()> =
        pieces.iter().flat_map(|piece| piece.columns.keys()).map(|name| (name.clone(), ())).collect();
    let rising = |times: &[i64]| times.windows(2).all(|pair| pair[0] < pair[1]);
    let apart = pieces.windows(2).all(|pair| pair[0].times_ns.last() < pair[1].times_ns.first());
    let mut series = Series {
        clock: pieces.first().map_or(Clock::None, |piece| piece.clock),
        times_ns: Vec::new(),
        columns: names.into_keys().map(|name| (name, Vec::new())).collect(),
        merged: 0,
        disagreeing: 0,
        sorted,
    };
    if apart && pieces.iter().all(|piece| rising(&piece.times_ns)) {
        for piece in &mut pieces {
            let rows = piece.times_ns.len();
            if series.times_ns.is_empty() {
                series.times_ns = std::mem::take(&mut piece.times_ns);
            } else {
                series.times_ns.append(&mut piece.times_ns);
            }
            for (name, values) in &mut series.columns {
                match piece.columns.shift_remove(name) {
                    Some(mut part) if values.is_empty() => std::mem::swap(values, &mut part),
                    Some(part) => values.extend(part),
                    None => values.resize(values.len() + rows, f64::NAN),
                }
            }
        }
    } else {
        merge(&mut series, &pieces, keep)?;
    }
    Ok((series, pieces))
}

fn check_alike(pieces: &[Piece]) -> Result<(), Error> {
    for pair in pieces.windows(2) {
        let [first, second] = pair else { continue };
        let (a, b) = (&first.shown, &second.shown);
        let message = match (&first.station, &second.station) {
            (Some(one), Some(other)) if one != other => format!(
                "{a} is of station {one}, {b} of {other}; expected files of one series. Ingest each series by itself; \
                 --add joins them in a document"
            ),
            _ if first.clock != second.clock => format!(
                "{a} and {b}: one states when it was taken, the other does not; expected files of one clock"
            ),
            _ if first.clock == Clock::None => format!(
                "{a} and {b} have no times, so that their order is not known; expected `time` in the mapping, or one file"
            ),
            _ => continue,
        };
        return Err(Error::Request(message));
    }
    Ok(())
}

/// Rows that come before their predecessor; an error unless they may be sorted.
fn falling(piece: &Piece, sort: bool) -> Result<usize, Error> {
    let falls: Vec<usize> =
        (1..piece.times_ns.len()).filter(|row| piece.times_ns[*row] < piece.times_ns[row - 1]).collect();
    match falls.first() {
        Some(row) if !sort => {
            let time = |row: usize| said(piece.clock, piece.times_ns[row]);
            let found = format!("{} after {} on line {}", time(*row), time(row - 1), piece.lines[row - 1]);
            let expected =
                "increasing times; the clock was set back there. If rows are only out of order, use --sort";
            Err(fault(&piece.shown, Place::Line(piece.lines[*row].into()), found, expected))
        }
        _ => Ok(falls.len()),
    }
}

fn said(clock: Clock, ns: i64) -> String {
    match clock {
        Clock::Utc => clock::text(ns),
        _ => format!("{} s", ns as f64 / SECOND_NS as f64),
    }
}

/// All rows in the order of time, those of one time made one.
fn merge(series: &mut Series, pieces: &[Piece], keep: Option<Keep>) -> Result<(), Error> {
    let mut order: Vec<(i64, u32, u32)> = Vec::new();
    for (number, piece) in pieces.iter().enumerate() {
        let rows = piece.times_ns.iter().enumerate();
        order.extend(rows.map(|(row, time)| (*time, number as u32, row as u32)));
    }
    order.sort_by_key(|(time, ..)| *time);
    let values: Vec<Vec<Option<&Vec<f64>>>> = pieces
        .iter()
        .map(|piece| series.columns.keys().map(|name| piece.columns.get(name)).collect())
        .collect();
    let mut columns = vec![Vec::with_capacity(order.len()); series.columns.len()];
    for same in order.chunk_by(|a, b| a.0 == b.0) {
        let mut disagree = false;
        for (column, kept) in columns.iter_mut().enumerate() {
            let mut chosen = f64::NAN;
            for (_, piece, row) in same {
                let value = values[*piece as usize][column].map_or(f64::NAN, |values| values[*row as usize]);
                if chosen.is_nan() {
                    chosen = value;
                } else if !value.is_nan() && value != chosen {
                    if keep.is_none() {
                        let name = series.columns.get_index(column).map_or("", |(name, _)| name.as_str());
                        return Err(disagreement(pieces, same, name, [chosen, value]));
                    }
                    disagree = true;
                    if keep == Some(Keep::Last) {
                        chosen = value;
                    }
                }
            }
            kept.push(chosen);
        }
        series.times_ns.push(same[0].0);
        let count = if disagree { &mut series.disagreeing } else { &mut series.merged };
        *count += same.len() - 1;
    }
    for (own, column) in series.columns.values_mut().zip(columns) {
        *own = column;
    }
    Ok(())
}

fn disagreement(pieces: &[Piece], same: &[(i64, u32, u32)], column: &str, values: [f64; 2]) -> Error {
    let place = |(_, piece, row): &(i64, u32, u32)| {
        let piece = &pieces[*piece as usize];
        (piece, piece.lines[*row as usize])
    };
    let ((first, first_line), (second, line)) = (place(&same[0]), place(&same[same.len() - 1]));
    let ([kept, other], at, shown) = (values, said(second.clock, same[0].0), &first.shown);
    let found = format!("{column} {other} at {at}, where {shown}, line {first_line} has {kept}");
    let expected =
        "one reading for each time; --keep first or --keep last selects the file to use where they disagree";
    fault(&second.shown, Place::Line(line.into()), found, expected)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::Source;
    use proptest::prelude::*;

    fn piece(name: &str, rows: &[(i64, f64)]) -> Piece {
        Piece {
            times_ns: rows.iter().map(|row| row.0 * SECOND_NS).collect(),
            columns: IndexMap::from([("sensor_x_nt".to_string(), rows.iter().map(|row| row.1).collect())]),
            lines: (2..).take(rows.len()).collect(),
            ..Piece::of(&Source::empty(name), "CSV")
        }
    }

    #[test]
    fn times_that_were_printed_to_the_millisecond() {
        let of = |rate: f64, rows: i64| {
            let time = |row: i64| (row as f64 / rate * 1e3).round() as i64 * 1_000_000;
            step_s(&(0..rows).filter(|row| !(40..45).contains(row)).map(time).collect::<Vec<_>>())
        };
        assert_eq!((of(16.0, 200), of(3.0, 4000), of(10.0, 50)), (Some(0.0625), Some(0.333_333), Some(0.1)));
        // A clock that scatters by more than its last digit is not even.
        let scattered: Vec<i64> = (0..50).map(|row| (row * 1000 + row * 7 % 5) * 1_000_000).collect();
        assert_eq!(step_s(&scattered), Some(1.002));
    }

    #[test]
    fn overlaps_that_agree_and_that_do_not() {
        let a = piece("a", &[(0, 1.0), (1, 2.0), (2, f64::NAN)]);
        let b = piece("b", &[(1, 2.0), (2, 3.0), (3, 4.0)]);
        let (series, _) = join(vec![b, a.clone()], None, false).expect("one series");
        assert_eq!(series.columns["sensor_x_nt"], [1.0, 2.0, 3.0, 4.0]);
        assert_eq!((series.merged, series.disagreeing), (2, 0));
        for (keep, value) in [(Keep::Last, 2.5), (Keep::First, 2.0)] {
            let both = vec![a.clone(), piece("c", &[(1, 2.5)])];
            let (series, _) = join(both, Some(keep), false).expect("one series");
            assert_eq!((series.columns["sensor_x_nt"][1], series.disagreeing), (value, 1));
        }
    }

    #[test]
    fn a_clock_set_back_and_gaps() {
        let back = piece("a", &[(0, 1.0), (5, 2.0), (3, 3.0)]);
        let (series, _) = join(vec![back], None, true).expect("sorted");
        assert_eq!((series.columns["sensor_x_nt"].clone(), series.sorted), (vec![1.0, 3.0, 2.0], 1));
        let times: Vec<i64> = [0, 1, 2, 5, 6, 7, 9].map(|time| time * SECOND_NS).into();
        let gaps = gaps(&times, 0, 1.0);
        assert_eq!((gaps.count, gaps.missing_rows), (2, 3));
        assert_eq!(gaps.longest[0], Gap { after_s: 2.0, seconds: 3.0 });
    }

    proptest! {
        /// However a series is cut into overlapping files, and in whatever order they are given, it comes
        /// back.
        #[test]
        fn a_series_comes_back_from_its_parts(
            cuts in prop::collection::vec((0_usize..60, 1_usize..40), 1..6),
            shuffle in any::<u64>(),
        ) {
            let rows: Vec<(i64, f64)> = (0..100).map(|row| (row * 3 % 307 + row * 7, (row as f64).sin())).collect();
            let mut pieces: Vec<Piece> =
                cuts.iter().map(|(from, length)| piece("p", &rows[*from..(from + length).min(100)])).collect();
            pieces.push(piece("all", &rows));
            let length = pieces.len();
            pieces.rotate_left((shuffle % length as u64) as usize);
            let (series, _) = join(pieces, None, true).expect("one series");
            let mut expected = rows;
            expected.sort_by_key(|row| row.0);
            prop_assert_eq!(&series.columns["sensor_x_nt"], &expected.iter().map(|row| row.1).collect::<Vec<_>>());
        }
    }
}
