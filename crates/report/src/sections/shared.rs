//! What several sections show: times in a unit that suits them, departures, spectral lines.

use common::{Departure, Recording, SpectralLine};
use page::number;
use page::plot::Dimension;
use page::words::key;

use crate::{Cell, Table};

/// A unit of time.
pub struct Clock {
    pub unit: &'static str,
    seconds: f64,
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
    pub fn axis(recording: &Recording) -> (Dimension, Vec<f64>) {
        match recording.column("time_s") {
            Some(time_s) => {
                let clock = Self::of(time_s);
                (Dimension::linear("time", clock.unit), clock.times(time_s))
            }
            None => ("row".into(), (0..recording.rows()).map(|row| row as f64).collect()),
        }
    }

    /// Times in this unit.
    pub fn times(&self, times_s: &[f64]) -> Vec<f64> {
        times_s.iter().map(|time| time / self.seconds).collect()
    }
}

/// A table of departures from a line or a model: what was looked for, and what was found.
pub fn departures(of: &str) -> Table {
    Table::new(
        "Departures that were tested; p is adjusted for the number of tests (trials factor)",
        &format!("{of} | departure | parameter | value | unit | p | found"),
    )
}

/// Adds the departures of one coil or sensor.
pub fn add_departures(table: &mut Table, of: &str, departures: &[Departure]) {
    for departure in departures {
        let (what, p) = (departure.departure.replace('_', " "), Cell::Probability(departure.p_adjusted));
        for (name, value) in &departure.parameter {
            let (name, unit) = key(name);
            table.row((of, &what, name, value, unit, p.clone(), departure.found));
        }
    }
}

/// A table of spectral lines.
pub fn lines() -> Table {
    Table::new("Spectral lines", "recording | sensor | frequency [Hz] | amplitude [nT] | what it is")
}

/// Adds spectral lines to their table.
pub fn add_lines(table: &mut Table, lines: &[SpectralLine]) {
    for line in lines {
        let amplitude = Cell::Figures(line.amplitude_nt, 3);
        table.row((&line.recording, &line.sensor, line.frequency_hz, amplitude, &line.name));
    }
}
