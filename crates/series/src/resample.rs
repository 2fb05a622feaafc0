//! Another step, without folding.

use common::number::{bare, counted};
use common::{Column, Columns, Error, Recording};

use joined::{Way, read_at, usual_step_s};

use crate::{phase_s, times};

/// Rows of a resampled recording at most.
const MOST: f64 = 1e8;

/// Readings at whole multiples of a step in UTC.
#[derive(Clone, Debug, PartialEq)]
pub struct Resample {
    /// The step, s.
    pub step_s: f64,
}

impl Resample {
    /// Resamples a recording; what was done, in words.
    pub fn run(&self, recording: &mut Recording, path: &str) -> Result<String, Error> {
        let time = times(recording, path)?;
        let phase = phase_s(recording, self.step_s);
        let place = |t: f64| (phase + t) / self.step_s;
        let (first, last) = match time {
            [first, .., last] => ((place(*first) - 1e-9).ceil(), (place(*last) + 1e-9).floor()),
            _ => {
                return Err(Error::Request(format!(
                    "\"{}\" has {}; expected two at least",
                    recording.id,
                    counted(time.len(), "row")
                )));
            }
        };
        if last - first > MOST {
            let message = format!(
                "\"{}\" would have {} rows; expected a longer --step",
                recording.id,
                bare(last - first)
            );
            return Err(Error::Request(message));
        }
        let count = (last - first) as i64 + 1;
        let at: Vec<f64> = (0..count).map(|row| (first + row as f64) * self.step_s - phase).collect();
        let mut columns = Columns::from([("time_s".to_string(), Column::from(at.clone()))]);
        let mut ways = Vec::new();
        for (name, values) in &recording.columns {
            // How many samples a mean has is nothing that can be read between rows.
            if name == "time_s" || name == "samples" || name.ends_with("_samples") {
                continue;
            }
            let read = read_at((path, &recording.id), time, values, &at, self.step_s)?;
            ways.push((name.clone(), read.way));
            columns.insert(name.clone(), Column::from(read.values));
        }
        let was = usual_step_s(time).unwrap_or(f64::NAN);
        let rows = time.len();
        recording.columns = columns;
        Ok(format!(
            "{} of {} s to {} of {} s{}",
            counted(rows, "row"),
            bare(was),
            at.len(),
            bare(self.step_s),
            said(&ways)
        ))
    }
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
