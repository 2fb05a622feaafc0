//! Times in a unit that suits them.

use common::Recording;

use crate::number;
use crate::plot::Dimension;

/// A unit of time.
pub struct Clock {
    /// Its name.
    pub unit: &'static str,
    seconds: f64,
}

impl Clock {
    /// Seconds, hours beyond four of them, days beyond four of those.
    pub fn of(times_s: &[f64]) -> Self {
        let span = number::ends(times_s.iter().copied()).map_or(0.0, |[low, high]| high - low);
        let (unit, seconds) = match span / 3600.0 {
            hours if hours > 96.0 => ("days", 86_400.0),
            hours if hours > 4.0 => ("h", 3600.0),
            _ => ("s", 1.0),
        };
        Self { unit, seconds }
    }

    /// The axis of a recording's times with its values, or of its rows where it has no times.
    pub fn axis(recording: &Recording) -> (Dimension, Vec<f64>) {
        match recording.column("time_s") {
            Some(time_s) => {
                let clock = Self::of(time_s);
                (Dimension::linear("time", clock.unit), clock.times(time_s))
            }
            None => (Dimension::linear("row", ""), (0..recording.rows()).map(|row| row as f64).collect()),
        }
    }

    /// Times in this unit.
    pub fn times(&self, times_s: &[f64]) -> Vec<f64> {
        times_s.iter().map(|time| time / self.seconds).collect()
    }
}
