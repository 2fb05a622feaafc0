//! Means over windows, with the number of samples in each.

use common::number::{bare, counted};
use common::{Column, Columns, Error, Recording};

use crate::{phase_s, times};
use joined::usual_step_s;
use std::ops::Range;

/// What a time may be off by its last digit, s: a row that is due at a boundary belongs to the window that
/// begins there.
const ROUNDING_S: f64 = 5e-7;
/// The column with the number of samples of a row.
const SAMPLES: &str = "samples";

/// Means over windows [n w, (n + 1) w) in UTC, at their middles.
#[derive(Clone, Debug, PartialEq)]
pub struct Average {
    /// The length of a window, s.
    pub window_s: f64,
    /// The least share of the samples that a full window has; a mean of fewer is missing.
    pub share: f64,
}

type Window = (i64, Range<usize>);

impl Average {
    /// Averages a recording; what was done, in words.
    pub fn run(&self, recording: &mut Recording, path: &str) -> Result<String, Error> {
        let time = times(recording, path)?;
        let (before, phase) = (time.len(), phase_s(recording, self.window_s));
        let windows = self.windows(time, phase);
        let middles: Column =
            windows.iter().map(|(number, _)| (*number as f64 + 0.5) * self.window_s - phase).collect();
        let ones = vec![1.0; before];
        let samples = recording.column(SAMPLES).unwrap_or(&ones);
        let all: Vec<f64> = windows.iter().map(|(_, rows)| sum(&samples[rows.clone()])).collect();
        let mut columns = Columns::from([("time_s".to_string(), middles)]);
        columns.insert(SAMPLES.into(), Column::from(all.clone()));
        let is_count = |name: &str| name == SAMPLES || name.ends_with("_samples");
        let mut lost = 0;
        let columns_of = recording.columns.iter().filter(|(name, _)| *name != "time_s" && !is_count(name));
        for (name, values) in columns_of {
            let own = recording.column(&format!("{name}_samples")).unwrap_or(samples);
            let least = self.share * self.full(time, values);
            let (mut counts, mut means) = (Vec::new(), Vec::new());
            for (_, rows) in &windows {
                let (mean, count, rows) = mean(&values[rows.clone()], &own[rows.clone()]);
                let enough = rows > 0 && rows as f64 >= least;
                lost += usize::from(!enough);
                means.push(if enough { mean } else { f64::NAN });
                counts.push(count);
            }
            columns.insert(name.clone(), Column::from(means));
            if counts != all {
                columns.insert(format!("{name}_samples"), Column::from(counts));
            }
        }
        recording.columns = columns;
        let lost = if lost > 0 {
            let share = bare(100.0 * self.share);
            format!("; {} of fewer than {share} % of the samples, missing", counted(lost, "mean"))
        } else {
            String::new()
        };
        let (least, most) = all.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(*v), b.max(*v)));
        let each = match (all.is_empty(), least == most) {
            (true, _) => String::new(),
            (_, true) => format!(", {} samples in each", bare(most)),
            _ => format!(", {} to {} samples in each", bare(least), bare(most)),
        };
        let (rows, means) = (counted(before, "row"), counted(windows.len(), "mean"));
        Ok(format!("{rows} to {means} of {} s{each}{lost}", bare(self.window_s)))
    }

    fn windows(&self, time: &[f64], phase: f64) -> Vec<Window> {
        let number = |t: f64| ((phase + t + ROUNDING_S) / self.window_s).floor() as i64;
        let mut windows: Vec<Window> = Vec::new();
        for (row, t) in time.iter().enumerate() {
            match windows.last_mut().filter(|(last, _)| *last == number(*t)) {
                Some((_, rows)) => rows.end = row + 1,
                None => windows.push((number(*t), row..row + 1)),
            }
        }
        windows
    }

    /// Rows with a value that a full window has: by the usual step between them.
    fn full(&self, time: &[f64], values: &[f64]) -> f64 {
        let there: Vec<f64> =
            time.iter().zip(values).filter(|(_, value)| value.is_finite()).map(|(time, _)| *time).collect();
        usual_step_s(&there).map_or(1.0, |step_s| (self.window_s / step_s).max(1.0))
    }
}

fn sum(values: &[f64]) -> f64 {
    values.iter().filter(|value| value.is_finite()).sum()
}

/// The mean weighted by samples, their number, and the number of rows.
fn mean(values: &[f64], samples: &[f64]) -> (f64, f64, usize) {
    let there = || values.iter().zip(samples).filter(|(value, samples)| value.is_finite() && **samples > 0.0);
    let count: f64 = there().map(|(_, samples)| samples).sum();
    // About the first value, so that a mean of large numbers keeps its digits.
    let first = there().next().map_or(f64::NAN, |(value, _)| *value);
    let sum: f64 = there().map(|(value, samples)| (value - first) * samples).sum();
    (first + sum / count, count, there().count())
}
