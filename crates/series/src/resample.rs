//! Another step, without folding.

use common::number::{bare, counted};
use common::{Column, Columns, Error, Recording};

use joined::{Way, read_at, usual_step_s};

use crate::{phase_s, times};

/// Rows of a resampled recording at most.
const MOST: f64 = 1e8;

/// Resamples a recording to whole multiples of a step in UTC; what was done, in words.
pub fn resample(recording: &mut Recording, path: &str, step_s: f64) -> Result<String, Error> {
    let time = times(recording, path)?;
    let phase = phase_s(recording, step_s);
    let place = |t: f64| (phase + t) / step_s;
    let [first, .., last] = time else {
        let (id, rows) = (&recording.id, counted(time.len(), "row"));
        return Err(Error::Request(format!("\"{id}\" has {rows}; expected two at least")));
    };
    let (first, last) = ((place(*first) - 1e-9).ceil(), (place(*last) + 1e-9).floor());
    if last - first > MOST {
        let (id, rows) = (&recording.id, bare(last - first));
        return Err(Error::Request(format!("\"{id}\" would have {rows} rows; expected a longer --step")));
    }
    let count = (last - first) as i64 + 1;
    let at: Vec<f64> = (0..count).map(|row| (first + row as f64) * step_s - phase).collect();
    let mut columns = Columns::from([("time_s".to_string(), Column::from(at.clone()))]);
    let mut ways = Vec::new();
    for (name, values) in &recording.columns {
        // How many samples a mean has is nothing that can be read between rows.
        if name == "time_s" || name == "samples" || name.ends_with("_samples") {
            continue;
        }
        let read = read_at((path, &recording.id), time, values, &at, step_s)?;
        ways.push((name.clone(), read.way));
        columns.insert(name.clone(), Column::from(read.values));
    }
    let was = bare(usual_step_s(time).unwrap_or(f64::NAN));
    let (rows, step, ways) = (counted(time.len(), "row"), bare(step_s), said(&ways));
    recording.columns = columns;
    Ok(format!("{rows} of {was} s to {} of {step} s{ways}", at.len()))
}

/// Columns that were interpolated.
pub fn said(ways: &[(String, Way)]) -> String {
    let names: Vec<&str> =
        ways.iter().filter(|(_, way)| *way == Way::Pieces).map(|(name, _)| name.as_str()).collect();
    if names.is_empty() {
        return String::new();
    }
    format!("; uneven or slower, therefore interpolated by piecewise cubics: {}", names.join(", "))
}
