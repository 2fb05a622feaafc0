//! A reading of a measurement.

use tables::{Place, listed};

use crate::Error;
use crate::clock::{self, Zone};
use crate::text::Source;

/// Columns of a recording besides its times; NaN is what was not read.
pub const COLUMNS: [&str; 8] = [
    "horizontal_deg",
    "vertical_deg",
    "residual_nt",
    "direction_deg",
    "reference_nt",
    "sensor_x_nt",
    "sensor_y_nt",
    "sensor_z_nt",
];
pub const VIEWS: [&str; 5] = ["Mark", "East", "West", "North", "South"];

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub time_ns: Option<i64>,
    /// One of [`VIEWS`]; empty for a reading of the scalar magnetometer alone.
    pub view: &'static str,
    /// In the order of [`COLUMNS`].
    pub values: [f64; 8],
}

impl Row {
    /// A reading of the circle that the view is set by (towards north and south the vertical one), residual in nT.
    pub fn at(view: &'static str, up: bool, circle_deg: f64, residual_nt: f64) -> Row {
        let level = if up { 90.0 } else { 270.0 };
        let read = match view {
            "Mark" => [circle_deg, level, f64::NAN, f64::NAN],
            "North" => [f64::NAN, circle_deg, residual_nt, 0.0],
            "South" => [f64::NAN, circle_deg, residual_nt, 180.0],
            _ => [circle_deg, level, residual_nt, f64::NAN],
        };
        let mut row = Row { time_ns: None, view, values: [f64::NAN; 8] };
        row.values[..4].copy_from_slice(&read);
        row
    }

    pub fn scalar(time_ns: i64, f_nt: f64) -> Row {
        let mut row = Row { time_ns: Some(time_ns), view: "", values: [f64::NAN; 8] };
        row.values[4] = f_nt;
        row
    }

    /// Whether the magnetometer is above the telescope (Up) or below it.
    fn face(&self) -> &'static str {
        if self.values[1] < 180.0 { "Up" } else { "Down" }
    }
}

/// From `to` to `from` the shorter way round, −180 to 180.
pub fn turn(from: f64, to: f64) -> f64 {
    (from - to + 180.0).rem_euclid(360.0) - 180.0
}

/// A time in UTC, as `2025-03-14T09:10:00` or with `_` between date and time.
pub fn moment(text: &str) -> Option<i64> {
    Zone::Fixed(0).moment(clock::iso(text.replace('_', "T").as_bytes())?).ok()
}

/// Whether each position was read, and each face of the mark twice. Errors: those that were not; `of` names
/// the measurement.
pub fn complete(source: &Source, place: Place, of: &str, rows: &[Row]) -> Result<(), Error> {
    let mut lacking = Vec::new();
    for (view, face) in VIEWS.iter().flat_map(|view| [(*view, "Up"), (*view, "Down")]) {
        match (view, rows.iter().filter(|row| row.view == view && row.face() == face).count()) {
            ("Mark", 1) => lacking.push(format!("{view}{face} a second time")),
            (_, 0) => lacking.push(format!("{view}{face}")),
            _ => {}
        }
    }
    if lacking.is_empty() {
        return Ok(());
    }
    let expected = "each of the eight positions, and the mark before and after them with the magnetometer above the telescope (Up) and below it (Down); write in what is missing, or leave this measurement out";
    Err(source.fault(place, format!("{of} without {}", listed(&lacking, 10)), expected))
}
