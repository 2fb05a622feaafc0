//! Times in a unit that suits them.

use crate::page::number;
use crate::page::plot::{Dimension, Timeline};
use common::{Document, MatrixStability, Recording};
use minijinja::{Value, context};

pub struct Clock {
    pub unit: &'static str,
    pub seconds: f64,
}

impl Clock {
    /// Seconds, hours beyond four of them, days beyond four of those.
    pub fn of(times_s: &[f64]) -> Self {
        let (unit, seconds) = match number::span(times_s.iter().copied()) / 3600.0 {
            hours if hours > 96.0 => ("days", 86_400.0),
            hours if hours > 4.0 => ("h", 3600.0),
            _ => ("s", 1.0),
        };
        Self { unit, seconds }
    }

    /// The axis of a recording's times with its values, or of its rows where it has no times.
    pub fn axis(recording: &Recording) -> (Dimension, Vec<f64>, Option<Timeline>) {
        match recording.column("time_s") {
            Some(time_s) => {
                let clock = Self::of(time_s);
                let timeline = clock.timeline(recording);
                (Dimension::linear("time", clock.unit), clock.times(time_s), Some(timeline))
            }
            None => ("row".into(), (0..recording.rows()).map(|row| row as f64).collect(), None),
        }
    }

    pub fn timeline(&self, recording: &Recording) -> Timeline {
        let (id, epoch_s) = (&recording.id, recording.start().map(|start| start.unix_s));
        Timeline { recording: id.clone(), group: id.clone(), unit_s: self.seconds, epoch_s }
    }

    pub fn times(&self, times_s: &[f64]) -> Vec<f64> {
        times_s.iter().map(|time| time / self.seconds).collect()
    }
}

/// The recording that began first, from whose start the times of a comparison count; of none that is dated the
/// first named.
pub fn earliest<'a>(document: &'a Document, ids: &[String]) -> Option<&'a Recording> {
    let named = |id: &String| document.recordings.iter().find(|recording| recording.id == *id);
    let start = |recording: &&Recording| recording.start().map_or(f64::INFINITY, |start| start.unix_s);
    ids.iter().filter_map(named).min_by(|a, b| start(a).total_cmp(&start(b)))
}

/// The middles of the windows of time and of the bands of periods in which a matrix was found.
pub fn middles(stability: &MatrixStability) -> Value {
    let windows = stability.windows.iter().flat_map(|windows| &windows.windows);
    let times: Vec<f64> = windows.map(|window| (window.from_s + window.to_s) / 2.0).collect();
    let clock = Clock::of(&times);
    let bands = stability.bands.iter().flat_map(|bands| &bands.bands);
    let periods: Vec<f64> = bands.map(|band| (band.from_period_s * band.to_period_s).sqrt()).collect();
    context! { unit => clock.unit, times => clock.times(&times), periods }
}
