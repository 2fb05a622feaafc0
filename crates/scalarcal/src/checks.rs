//! Rows that are not used, and what the residuals say of them.

use common::Axis;
use common::number::{counted, significant};
use estimate::robust::scale_of;
use estimate::stats::two_sided_p;

use crate::read::Series;

/// A reading that is the largest of its sensor this many times as often as the next smaller one stands at the end of the range.
const PILED_UP: usize = 5;
/// Rows of a pile at least.
const LEAST: usize = 5;
/// Rows are disturbed that are as far from the rest with this probability by chance, among all of them.
const DISTURBED: f64 = 0.01;

/// Leaves out rows in which an output stands at the end of its range; gives how many by sensor.
pub fn without_saturated(series: &mut [Series]) -> Vec<(Axis, usize)> {
    let mut left_out = Vec::new();
    for axis in Axis::ALL {
        let k = axis.index();
        let mut all: Vec<f64> = series.iter().flat_map(|one| one.readings[k].iter().copied()).collect();
        all.sort_by(f64::total_cmp);
        let high = pile(all.iter().rev().copied());
        let low = pile(all.iter().copied());
        let ends = |value: f64| high == Some(value) || low == Some(value);
        let mut count = 0;
        for one in series.iter_mut() {
            let keep: Vec<bool> = one.readings[k].iter().map(|value| !ends(*value)).collect();
            count += keep.iter().filter(|keep| !**keep).count();
            retain(one, &keep);
        }
        if count > 0 {
            left_out.push((axis, count));
        }
    }
    left_out
}

/// The first value of an ordered list, where it comes far more often than the next.
fn pile(mut ordered: impl Iterator<Item = f64>) -> Option<f64> {
    let first = ordered.next()?;
    let mut count = 1;
    let mut next = None;
    for value in ordered.by_ref() {
        if value == first {
            count += 1;
        } else {
            next = Some(value);
            break;
        }
    }
    let next = next?;
    let beside = 1 + ordered.take_while(|value| *value == next).count();
    (count >= LEAST && count >= PILED_UP * beside).then_some(first)
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
    let repeats = |one: &Series| {
        (1..one.len()).filter(|row| one.readings.iter().all(|column| column[*row] == column[row - 1])).count()
    };
    let (count, rows) =
        series.iter().fold((0, 0), |(count, rows), one| (count + repeats(one), rows + one.len()));
    (count * 10 > rows && count > LEAST).then(|| {
        format!(
            "{} of {rows} repeat the readings of the row before in all three sensors: rows that say nothing new make the \
             uncertainties too small. Did the logger read faster than the sensors?",
            counted(count, "row")
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
    let far = |value: f64| two_sided_p(value / scale, f64::INFINITY) * (count as f64) < DISTURBED;
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
