//! Readings that no longer follow the field.

use common::number::counted;
use common::{Axis, Document, Saturation};

use crate::readings::{Run, along, code_width, span};
use crate::{Error, Result};

/// Readings within this share of the largest one stand still.
const STILL: f64 = 1e-6;
/// Codes of the converter by which a reading that stands still may differ.
const CODES: f64 = 2.0;
/// A single reading falls short of the line by so much of itself before it counts as standing still.
const SHORT: f64 = 1e-3;
/// A reading is missed by so many times what it may differ by before it counts as standing still.
const MISSED: f64 = 20.0;

/// Takes out of the runs the readings at which the output is saturated though the field goes on.
pub fn take_out(document: &Document, runs: &mut [Run<'_>], sensor: Axis) -> Result<Option<Saturation>> {
    let mut found = Saturation::default();
    for run in runs.iter_mut() {
        let (field, code) = (along(run), code_width(document, run));
        for (side, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let flat = flat(run, &field, sign, code);
            let Some(begin) = flat.iter().copied().min_by(|a, b| field[*a].abs().total_cmp(&field[*b].abs()))
            else {
                continue;
            };
            found.count += flat.len();
            found.readings[side] = Some(run.reading[begin]);
            found.fields_nt[side] = Some(field[begin]);
            run.rows.retain(|row| !flat.contains(row));
        }
        if run.rows.len() < 4 {
            return Err(Error::Unanswerable(format!(
                "recording \"{}\": the output of sensor {sensor} is saturated in all but {}; smaller fields are needed",
                run.context.recording.id,
                counted(run.rows.len(), "reading")
            )));
        }
    }
    Ok((found.count > 0).then_some(found))
}

/// Rows on one side that read the same though their fields differ: none unless there are at least two.
fn flat(run: &Run<'_>, field: &[f64], sign: f64, code: f64) -> Vec<usize> {
    let reading = |row: usize| sign * run.reading[row];
    let Some(extreme) = run.rows.iter().map(|row| reading(*row)).reduce(f64::max).filter(|v| *v > 0.0) else {
        return Vec::new();
    };
    let still = (STILL * extreme).max(CODES * code);
    let rows: Vec<usize> = run.rows.iter().copied().filter(|row| reading(*row) >= extreme - still).collect();
    // The slope where the field is smaller says how far the readings should be apart.
    let Some(slope) = slope(run, field) else { return Vec::new() };
    let apart = span(rows.iter().map(|row| sign * field[*row]));
    if rows.len() >= 2 && apart * slope > MISSED * still {
        return rows;
    }
    // One reading alone stands still where it falls short of the line of the inner ones by far.
    let last = run.rows.iter().copied().max_by(|a, b| (sign * field[*a]).total_cmp(&(sign * field[*b])));
    let short =
        |row: usize| slope * sign * field[row] - reading(row) > SHORT * reading(row).abs() + MISSED * still;
    last.filter(|row| short(*row)).into_iter().collect()
}

/// Reading for each nT where the field is at most half of its largest size.
fn slope(run: &Run<'_>, field: &[f64]) -> Option<f64> {
    let largest = run.rows.iter().map(|row| field[*row].abs()).fold(0.0, f64::max);
    let inner = || run.rows.iter().copied().filter(|row| field[*row].abs() <= largest / 2.0);
    let low = inner().min_by(|a, b| field[*a].total_cmp(&field[*b]))?;
    let high = inner().max_by(|a, b| field[*a].total_cmp(&field[*b]))?;
    (field[high] > field[low]).then(|| (run.reading[high] - run.reading[low]) / (field[high] - field[low]))
}
