//! Rows that are not used, and what the residuals say of them.

use common::Axis;
use common::number::{counted, significant};
use estimate::robust::scale_of;
use estimate::stats::two_sided_p;

use crate::ends::{self, Ends};
use crate::read::Series;

/// Fewer rows that repeat the one before are not left out or told.
const LEAST: u64 = 5;
/// A logger repeats readings where more than one row in so many does.
const OFTEN: u64 = 10;
/// Rows are disturbed that are as far from the rest with this probability by chance, among all of them.
const DISTURBED: f64 = 0.01;
/// Within so many standard deviations no row is disturbed.
const NEAR: f64 = 2.5;

/// Leaves out rows in which an output stands at the end of its range; gives how many by sensor.
pub fn without_saturated(series: &mut [Series]) -> [u64; 3] {
    let mut found = Ends::default();
    for one in series.iter() {
        for row in 0..one.len() {
            found.take(one.reading(row));
        }
    }
    let piles = found.piles();
    let mut left_out = [0; 3];
    for one in series.iter_mut().filter(|_| piles != 0) {
        let at: Vec<Option<Axis>> =
            (0..one.len()).map(|row| ends::sensor(found.at(one.reading(row), piles))).collect();
        at.iter().flatten().for_each(|axis| left_out[axis.index()] += 1);
        retain(one, &at.iter().map(Option::is_none).collect::<Vec<bool>>());
    }
    left_out
}

/// Their number by the reason.
pub fn saturated(by_sensor: [u64; 3]) -> Vec<(String, u64)> {
    let of = |(axis, count)| (format!("sensor {axis} at the end of its range"), count);
    Axis::ALL.into_iter().zip(by_sensor).filter(|(_, count)| *count > 0).map(of).collect()
}

pub fn retain(series: &mut Series, keep: &[bool]) {
    series.rows = those(&series.rows, keep);
    series.time_s = series.time_s.as_ref().map(|time| those(time, keep));
    series.readings = series.readings.each_ref().map(|column| those(column, keep));
    series.magnitude_nt = those(&series.magnitude_nt, keep);
}

/// Those of the values of rows that are kept.
pub fn those<T: Copy>(column: &[T], keep: &[bool]) -> Vec<T> {
    column.iter().zip(keep).filter(|(_, keep)| **keep).map(|(value, _)| *value).collect()
}

/// Whether so many rows repeat the one before in all three sensors that they are no accident.
fn frozen(count: u64, rows: u64) -> bool {
    count * OFTEN > rows && count > LEAST
}

/// Rows of a stream that repeat the one before, in a sentence; a logger that froze repeats many.
pub fn repeats(count: u64, rows: u64) -> Option<String> {
    frozen(count, rows).then(|| {
        format!(
            "{} of {rows} repeat the previous row in all three sensors: repeated readings make the uncertainties too small. Is the logger faster than the sensors?",
            counted(count as usize, "row")
        )
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
pub fn disturbed(series: &[Series], residuals: &[Vec<f64>]) -> Option<String> {
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
        format!(
            "{} of {count} are outliers (p < {DISTURBED}), the largest by {} nT in \"{}\", row {}: --robust leaves them out",
            counted(number, "row"),
            significant(value, 3),
            one.id,
            one.rows[row]
        )
    })
}
