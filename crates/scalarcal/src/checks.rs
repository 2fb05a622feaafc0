//! Rows that are not used, and what the residuals say of them.

use common::Axis;
use common::number::{counted, significant};
use estimate::robust::scale_of;
use estimate::stats::two_sided_p;

use crate::ends::{self, Ends};
use crate::read::Series;

/// Fewer rows that repeat the one before are not told.
const LEAST: u64 = 5;
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

/// Keeps some of the rows.
pub fn retain(series: &mut Series, keep: &[bool]) {
    if keep.iter().all(|keep| *keep) {
        return;
    }
    let of = |column: &[f64]| {
        column.iter().zip(keep).filter(|(_, keep)| **keep).map(|(value, _)| *value).collect()
    };
    series.rows = series.rows.iter().zip(keep).filter(|(_, keep)| **keep).map(|(row, _)| *row).collect();
    series.time_s = series.time_s.as_deref().map(of);
    series.readings = series.readings.each_ref().map(|column| of(column));
    series.magnitude_nt = of(&series.magnitude_nt);
}

/// Rows that repeat the one before in all three sensors, in a sentence; a logger that froze repeats many.
pub fn repeated(series: &[Series]) -> Option<String> {
    let of = |count: fn(&Series) -> usize| series.iter().map(|one| count(one) as u64).sum();
    repeats(of(repeated_in), of(Series::len))
}

fn repeated_in(one: &Series) -> usize {
    (1..one.len()).filter(|row| one.readings.iter().all(|column| column[*row] == column[row - 1])).count()
}

/// The same of so many that repeat the one before, among so many rows.
pub fn repeats(count: u64, rows: u64) -> Option<String> {
    (count * 10 > rows && count > LEAST).then(|| {
        format!(
            "{} of {rows} repeat the readings of the row before in all three sensors: rows that say nothing new make the \
             uncertainties too small. Did the logger read faster than the sensors?",
            counted(count as usize, "row")
        )
    })
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
            "{} of {count} further from the rest than noise explains (p < {DISTURBED}), the furthest by {} nT in \"{}\", row {}: \
             --robust weighs such rows down",
            counted(number, "row"),
            significant(value, 3),
            one.id,
            one.rows[row]
        )
    })
}
