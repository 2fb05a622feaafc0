//! Rows that are not used: at the ends of the sensors' ranges, by how often the largest and the smallest
//! reading came, for two sets from those of each; rows that repeat the one before; large residuals.

use common::number::{counted, significant};
use common::{Axis, Code, Finding};
use estimate::robust::scale_of;
use estimate::stats::two_sided_p;
use serde::{Deserialize, Serialize};

use crate::read::Series;

/// Fewer rows that repeat the one before are not left out or told.
const LEAST: u64 = 5;
/// A logger repeats readings where more than one row in so many does.
const OFTEN: u64 = 10;
/// Rows are disturbed that are as far from the rest with this probability by chance, among all of them.
const DISTURBED: f64 = 0.01;
/// Within so many standard deviations no row is disturbed.
const NEAR: f64 = 2.5;
/// A sensor's furthest reading is the end of its range where it came this many times as often as the next.
const PILED_UP: u64 = 5;
/// Rows of such a pile at least.
const LEAST_PILED_UP: u64 = 5;
/// Which way the ends lie.
const SIGNS: [f64; 2] = [1.0, -1.0];
const ALL: At = 0b11_1111;

/// The furthest reading one way and the one next to it, each with how often it came.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct End {
    first: (f64, u64),
    #[serde(default, skip_serializing_if = "Option::is_none")]
    next: Option<(f64, u64)>,
}

impl End {
    /// Takes a reading that came so often; whether it goes beyond what was the furthest.
    fn take(&mut self, (value, count): (f64, u64), sign: f64) -> bool {
        let beyond = |other: f64| sign * value > sign * other;
        if beyond(self.first.0) {
            self.next = Some(self.first);
            self.first = (value, count);
            return true;
        }
        if value == self.first.0 {
            self.first.1 += count;
            return false;
        }
        match &mut self.next {
            Some(next) if value == next.0 => next.1 += count,
            Some(next) if !beyond(next.0) => {}
            next => *next = Some((value, count)),
        }
        false
    }

    fn is_pile(&self) -> bool {
        let (_, count) = self.first;
        count >= LEAST_PILED_UP && self.next.is_some_and(|(_, beside)| count >= PILED_UP * beside)
    }
}

/// Which of the six ends a row stands at: bit 2 k for the upper end of sensor k, 2 k + 1 for the lower.
pub type At = u8;

/// The ends of three sensors, upper and lower.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Ends([[Option<End>; 2]; 3]);

impl Ends {
    pub fn is_empty(&self) -> bool {
        self.0.iter().flatten().all(Option::is_none)
    }

    /// Takes a row; gives the ends at which it stands, and those that it moved.
    pub fn take(&mut self, readings: [f64; 3]) -> (At, At) {
        let row = Self(readings.map(|value| [Some(End { first: (value, 1), next: None }); 2]));
        let (moved, beside) = self.merge(&row);
        (ALL & !beside, moved)
    }

    /// Takes the ends of other rows; gives the ends moved here, and those that are not the furthest there.
    pub fn merge(&mut self, other: &Self) -> (At, At) {
        let (mut here, mut there) = (0, 0);
        for (place, (mine, theirs)) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()).enumerate() {
            let (Some(theirs), sign) = (theirs, SIGNS[place % 2]) else { continue };
            let Some(mine) = mine else {
                *mine = Some(*theirs);
                continue;
            };
            if mine.take(theirs.first, sign) {
                here |= 1 << place;
            } else if mine.first.0 != theirs.first.0 {
                there |= 1 << place;
            }
            if let Some(next) = theirs.next {
                mine.take(next, sign);
            }
        }
        (here, there)
    }

    pub fn piles(&self) -> At {
        self.those(|_, end| end.is_pile())
    }

    /// The ends, among some, at which a row stands.
    pub fn at(&self, readings: [f64; 3], among: At) -> At {
        among & self.those(|axis, end| end.first.0 == readings[axis])
    }

    /// The ends of which something holds, by sensor and end.
    fn those(&self, holds: impl Fn(usize, &End) -> bool) -> At {
        let ends = self.0.iter().flatten().enumerate();
        let of = |(place, end): (usize, &Option<End>)| {
            At::from(end.as_ref().is_some_and(|end| holds(place / 2, end))) << place
        };
        ends.map(of).sum()
    }

    /// The largest and the smallest reading of a sensor.
    pub fn range(&self, axis: usize) -> Option<[f64; 2]> {
        let [high, low] = self.0[axis];
        Some([high?.first.0, low?.first.0])
    }

    /// Whether all are finite numbers, after reading them from outside.
    pub fn is_whole(&self) -> bool {
        let all = self.0.iter().flatten().flatten();
        all.flat_map(|end| [Some(end.first), end.next]).flatten().all(|(value, _)| value.is_finite())
    }
}

/// The first sensor that stands at an end.
pub fn sensor_at(at: At) -> Option<Axis> {
    Axis::ALL.into_iter().find(|axis| at >> (2 * axis.index()) & 3 != 0)
}

/// Leaves out rows in which an output stands at the end of its range; gives how many by sensor.
pub fn without_saturated(series: &mut [Series]) -> [u64; 3] {
    let mut found = Ends::default();
    for readings in series.iter().flat_map(|one| (0..one.len()).map(|row| one.reading(row))) {
        found.take(readings);
    }
    let piles = found.piles();
    let mut left_out = [0; 3];
    for one in series.iter_mut().filter(|_| piles != 0) {
        let at: Vec<Option<Axis>> =
            (0..one.len()).map(|row| sensor_at(found.at(one.reading(row), piles))).collect();
        at.iter().flatten().for_each(|axis| left_out[axis.index()] += 1);
        retain(one, &at.iter().map(Option::is_none).collect::<Vec<bool>>());
    }
    left_out
}

pub fn saturated(by_sensor: [u64; 3]) -> Vec<(String, u64)> {
    let of = |(axis, count)| (format!("sensor {axis} at the end of its range"), count);
    Axis::ALL.into_iter().zip(by_sensor).filter(|(_, count)| *count > 0).map(of).collect()
}

pub fn retain(series: &mut Series, keep: &[bool]) {
    series.rows = those(&series.rows, keep);
    series.time_s = series.time_s.as_ref().map(|time| those(time, keep));
    series.readings = series.readings.each_ref().map(|column| those(column, keep));
    series.magnitude_nt = those(&series.magnitude_nt, keep);
    series.follows.iter_mut().for_each(|column| *column = those(column, keep));
}

/// Those of the values of rows that are kept.
fn those<T: Copy>(column: &[T], keep: &[bool]) -> Vec<T> {
    column.iter().zip(keep).filter(|(_, keep)| **keep).map(|(value, _)| *value).collect()
}

/// Whether so many rows repeat the one before in all three sensors that they are no accident.
fn frozen(count: u64, rows: u64) -> bool {
    count * OFTEN > rows && count > LEAST
}

/// Rows of a stream that repeat the one before, in a sentence; a logger that froze repeats many.
pub fn repeats(count: u64, rows: u64) -> Option<Finding> {
    frozen(count, rows).then(|| {
        Code::RepeatedReadings.said(format!(
            "{} of {rows} repeat the previous row in all three sensors: repeated readings make the uncertainties too small. Is the logger faster than the sensors?",
            counted(count as usize, "row")
        ))
    })
}

/// Leaves out rows that repeat the one before, where there are many; gives how many. A logger that reads
/// faster than the sensors repeats readings: they say nothing new, and are those of an earlier moment.
pub fn without_repeated(series: &mut [Series]) -> u64 {
    let fresh = |one: &Series| -> Vec<bool> {
        (0..one.len()).map(|row| row == 0 || one.reading(row) != one.reading(row - 1)).collect()
    };
    let keep: Vec<Vec<bool>> = series.iter().map(fresh).collect();
    let rows: usize = series.iter().map(Series::len).sum();
    let count = keep.iter().flatten().filter(|keep| !**keep).count() as u64;
    if !frozen(count, rows as u64) {
        return 0;
    }
    series.iter_mut().zip(&keep).for_each(|(one, keep)| retain(one, keep));
    count
}

/// Rows far from the rest, in a sentence.
pub fn disturbed(series: &[Series], residuals: &[Vec<f64>]) -> Option<Finding> {
    let mut sizes: Vec<f64> = residuals.iter().flatten().map(|value| value.abs()).collect();
    let count = sizes.len();
    let scale = scale_of(&mut sizes);
    if scale <= 0.0 || scale.is_nan() {
        return None;
    }
    let far = |value: f64| {
        value.abs() > NEAR * scale && two_sided_p(value / scale, f64::INFINITY) * (count as f64) < DISTURBED
    };
    let number = residuals.iter().flatten().filter(|value| far(**value)).count();
    let (recording, row, value) = residuals
        .iter()
        .enumerate()
        .flat_map(|(number, values)| values.iter().enumerate().map(move |(row, value)| (number, row, *value)))
        .max_by(|a, b| a.2.abs().total_cmp(&b.2.abs()))?;
    (number > 0).then(|| {
        let one = &series[recording];
        Code::Outliers.about(significant(value, 3)).said(format!(
            "{} of {count} are outliers (p < {DISTURBED}), the largest by {} nT in \"{}\", row {}: --robust leaves them out",
            counted(number, "row"),
            significant(value, 3),
            one.id,
            one.rows[row]
        ))
    })
}
