//! Columns read at other times.

use common::{Columns, Recording};
use estimate::even::{GAP, interpolated};
use estimate::stats::median;

use super::piece::cut;
use crate::{Result, earliest, rising};

/// Times as near as this, s, are one.
const SAME_S: f64 = 5e-7;
/// A step that is longer by less than this share is not longer.
const AS_FAST: f64 = 1.001;

/// How values came to their new times.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// The times are the same.
    Same,
    /// Band-limited: windowed sinc, above the slower series' Nyquist frequency taken out.
    BandLimited,
    /// Cubic pieces that do not overshoot, for slow and for uneven series.
    Pieces,
}

/// A column at other times.
#[derive(Clone, Debug)]
pub struct Reading {
    /// NaN outside and in gaps.
    pub values: Vec<f64>,
    /// How they came there.
    pub way: Way,
}

/// The usual step of rising times: their median; None for fewer than two.
pub fn usual_step_s(time: &[f64]) -> Option<f64> {
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    (!steps.is_empty()).then(|| median(&steps))
}

/// Values of a recording at rising `time`, read at rising times `at` that are `step_s` apart. A series that
/// is no slower than `at` is cut where its times jump and read band-limited, so that nothing folds, after it
/// was made even where it is not; a slower one by cubic pieces.
/// Refused: times with a gap so long that hardly any row of an even grid would be a recorded one.
pub fn read_at(
    recording: (&str, &str),
    time: &[f64],
    values: &[f64],
    at: &[f64],
    step_s: f64,
) -> Result<Reading> {
    let there = || time.iter().zip(values).filter(|(_, value)| value.is_finite());
    let (time, values): (Vec<f64>, Vec<f64>) = there().map(|(time, value)| (*time, *value)).unzip();
    let Some(own_s) = usual_step_s(&time) else {
        let only =
            |t: &f64| time.first().filter(|own| (*own - t).abs() <= SAME_S).map_or(f64::NAN, |_| values[0]);
        return Ok(Reading { values: at.iter().map(only).collect(), way: Way::Same });
    };
    // Of a faster series the rows at those times are not enough: what lies between would fold.
    if let Some(values) = same(&time, &values, at).filter(|_| own_s * AS_FAST >= step_s) {
        return Ok(Reading { values, way: Way::Same });
    }
    // A series that is slower than the new times holds nothing that could fold.
    if own_s > step_s * AS_FAST {
        return Ok(Reading { values: interpolated(&time, &values, at, GAP * own_s), way: Way::Pieces });
    }
    let (path, id) = recording;
    let mut read = Reading { values: vec![f64::NAN; at.len()], way: Way::BandLimited };
    for piece in cut(&time, vec![values.into()], path, id)? {
        if piece.told.is_some() {
            read.way = Way::Pieces;
        }
        let Some(of_piece) = piece.read(at, step_s) else { continue };
        read.values[of_piece.rows].copy_from_slice(&of_piece.columns[0]);
    }
    Ok(read)
}

/// Values where each time within the series is one of it.
fn same(time: &[f64], values: &[f64], at: &[f64]) -> Option<Vec<f64>> {
    let (first, last) = (time[0] - SAME_S, time[time.len() - 1] + SAME_S);
    let of = |t: &f64| {
        if *t < first || *t > last {
            return Some(f64::NAN);
        }
        let place = time.partition_point(|own| own + SAME_S < *t);
        time.get(place).filter(|own| (*own - t).abs() <= SAME_S).map(|_| values[place])
    };
    at.iter().map(of).collect()
}

/// Columns of a recording at the times of another.
#[derive(Clone, Debug)]
pub struct Onto {
    /// The columns, `time_s` left out.
    pub columns: Columns,
    /// How each came there.
    pub ways: Vec<(String, Way)>,
    /// The recording's usual step, s.
    pub own_step_s: Option<f64>,
    /// How many of the times lie within it.
    pub there: usize,
}

/// The columns of the second of two recordings (each with its place in the document) that are `wanted`, at
/// times of the clock of the first.
/// Refused: recordings of which one says when it began and the other does not; times that are none.
pub fn onto(
    base: (usize, &Recording),
    other: (usize, &Recording),
    at: &[f64],
    wanted: impl Fn(&str) -> bool,
) -> Result<Onto> {
    earliest(&[base, other])?;
    let ahead_s = other.1.start().zip(base.1.start()).map_or(0.0, |(own, base)| own.unix_s - base.unix_s);
    let path = format!("recordings[{}]", other.0);
    let time = rising(other.1, &path, ahead_s)?;
    let step_s = usual_step_s(at).unwrap_or(1.0);
    let (mut columns, mut ways) = (Columns::new(), Vec::new());
    for (name, column) in other.1.columns.iter().filter(|(name, _)| *name != "time_s" && wanted(name)) {
        let read = read_at((&path, &other.1.id), &time, column, at, step_s)?;
        ways.push((name.clone(), read.way));
        columns.insert(name.clone(), common::Column::from(read.values));
    }
    let there = at.iter().filter(|t| time.first() <= Some(t) && time.last() >= Some(t)).count();
    Ok(Onto { columns, ways, own_step_s: usual_step_s(&time), there })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(time: &[f64], values: &[f64], at: &[f64], step_s: f64) -> Reading {
        read_at(("recordings[0]", "it"), time, values, at, step_s).expect("read")
    }

    fn sine(time: &[f64], period: f64) -> Vec<f64> {
        time.iter().map(|t| (std::f64::consts::TAU * t / period).sin()).collect()
    }

    #[test]
    fn a_sine_comes_back_and_none_folds() {
        let time: Vec<f64> = (0..2000).map(f64::from).collect();
        let at: Vec<f64> = (0..180).map(|k| 100.0 + 10.0 * f64::from(k)).collect();
        let slow = read(&time, &sine(&time, 200.0), &at, 10.0);
        assert_eq!(slow.way, Way::BandLimited);
        let (inner, known) = (30..150, sine(&at, 200.0));
        assert!(inner.clone().all(|row| (slow.values[row] - known[row]).abs() < 1e-3));
        // A period of 3.3 s would fold to 33 s with rows taken as they are.
        let fast = read(&time, &sine(&time, 3.3), &at, 10.0).values;
        assert!(fast[inner].iter().all(|value| value.abs() < 1e-3));
    }

    #[test]
    fn slow_uneven_and_open_series() {
        let time: Vec<f64> = (0..60).map(|row| f64::from(row) * 60.0 + f64::from(row * 7 % 5)).collect();
        let at: Vec<f64> = (0..3000).map(f64::from).collect();
        let slow = read(&time, &sine(&time, 3600.0), &at, 1.0);
        assert_eq!(slow.way, Way::Pieces);
        assert!(slow.values.iter().zip(sine(&at, 3600.0)).all(|(a, b)| (a - b).abs() < 5e-3));
        let with_gap = [0.0, 1.0, 2.0, 9.0, 10.0, 11.5];
        let open = read(&with_gap, &[1.0; 6], &[0.5, 2.0, 5.0, 9.5, 12.0], 0.5).values;
        assert!(open[0] == 1.0 && open[1] == 1.0 && open[2].is_nan() && open[3] == 1.0 && open[4].is_nan());
    }

    #[test]
    fn a_series_that_jumps_is_read_on_either_side_by_itself() {
        let time: Vec<f64> = (0..400).map(|k| f64::from(k) + if k < 200 { 0.0 } else { 0.4 }).collect();
        let at: Vec<f64> = (0..395).map(|k| f64::from(k) + 0.25).collect();
        let found = read(&time, &sine(&time, 60.0), &at, 1.0);
        assert_eq!(found.way, Way::BandLimited);
        let known = sine(&at, 60.0);
        for (row, value) in found.values.iter().enumerate() {
            assert!(value.is_nan() || (value - known[row]).abs() < 3e-3, "{row}: {value} {}", known[row]);
        }
        let missing = found.values[50..350].iter().filter(|value| value.is_nan()).count();
        assert!((1..=8).contains(&missing), "{missing} missing beside the jump");
    }
}
