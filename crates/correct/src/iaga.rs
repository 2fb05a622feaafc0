//! Corrected fields as IAGA-2002, the exchange format of observatories (IAGA Division V, working group V-DAT;
//! <https://www.ncei.noaa.gov/services/world-data-system/v-dat-working-group/iaga-2002-data-exchange-format>).

use common::time::Start;
use common::{Axis, Error, Recording};
use jiff::tz::TimeZone;
use jiff::{SignedDuration, Timestamp};
use program::pipe::Sink;
use std::fmt::Write;
use std::path::Path;

use crate::Corrected;
use crate::noise::length_and_step_s;

/// A value that is missing.
const MISSING: f64 = 99_999.0;
/// A component that is not observed.
const NOT_OBSERVED: f64 = 88_888.0;
const LABEL: usize = 24;
const LINE: usize = 69;

/// For whom a file is written.
#[derive(Clone, Copy, Debug)]
pub struct Station<'a> {
    /// The station's code, three or four letters or digits.
    pub code: &'a str,
    /// When `time_s` is zero, RFC 3339, where the recording does not say it.
    pub start: Option<&'a str>,
}

/// A file that is being written: X north, Y east, Z down, and F as the scalar magnetometer read it.
pub struct IagaWriter {
    sink: Sink,
    code: String,
    start_s: f64,
    last_ms: Option<i64>,
    rows: u64,
}

impl IagaWriter {
    /// Opens a file, or standard output.
    ///
    /// # Errors
    ///
    /// A code that is none; a recording without `start`; a file that cannot be written.
    pub fn create(output: Option<&Path>, station: Station<'_>, recording: &Recording) -> Result<Self, Error> {
        let code = station.code.to_ascii_uppercase();
        if !(3..=4).contains(&code.len()) || !code.bytes().all(|byte| byte.is_ascii_alphanumeric()) {
            return Err(Error::Request(format!(
                "\"{}\" is not a station code; expected three or four letters or digits",
                station.code
            )));
        }
        let told = station.start.map(|text| {
            let expected = "--start is not a time; expected RFC 3339, as in 2026-05-26T14:44:35Z";
            Start::parse(text).ok_or_else(|| Error::Request(format!("\"{text}\" after {expected}")))
        });
        let Some(start) = told.transpose()?.or(recording.start()) else {
            let unknown = "IAGA-2002 needs dates, and the origin of time_s is unknown; give --start, or --recording with a start in the document";
            return Err(Error::Request(unknown.into()));
        };
        Ok(Self { sink: Sink::open(output)?, code, start_s: start.unix_s, last_ms: None, rows: 0 })
    }

    /// Writes rows. False: the reader of standard output has gone.
    ///
    /// # Errors
    ///
    /// Rows without a time, or out of order.
    pub fn write(&mut self, recording: &Recording, corrected: &Corrected) -> Result<bool, Error> {
        let Some(times) = recording.column("time_s") else {
            return Err(Error::Request("found no column time_s; IAGA-2002 has a time in each row".into()));
        };
        let mut text = String::new();
        if self.rows == 0 {
            text.push_str(&self.header(length_and_step_s(times).map(|[_, step_s]| step_s)));
        }
        let scalar = recording.column("reference_nt");
        for (row, time_s) in times.iter().enumerate() {
            let field = Axis::ALL.map(|axis| corrected.field_nt[axis.index()][row]);
            let total = scalar.map_or(NOT_OBSERVED, |column| column[row]);
            let [x, y, z, f] = [field[0], field[1], field[2], total]
                .map(|value| if value.is_finite() { value } else { MISSING });
            self.rows += 1;
            let moment = self.moment(*time_s)?;
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{moment}    {x:>9.2} {y:>9.2} {z:>9.2} {f:>9.2}");
        }
        self.sink.write(&text)
    }

    /// Date, time to the millisecond, day of the year.
    fn moment(&mut self, time_s: f64) -> Result<String, Error> {
        let ms = ((self.start_s + time_s) * 1e3).round() as i64;
        let refused = |expected: &str| {
            Error::Request(format!("row {}: found time_s = {time_s}; expected {expected}", self.rows))
        };
        if !time_s.is_finite() || self.last_ms.is_some_and(|last| ms <= last) {
            return Err(refused("times that increase by at least 1 ms, the resolution of IAGA-2002"));
        }
        let timestamp = Timestamp::from_duration(SignedDuration::from_millis(ms))
            .map_err(|_| refused("a time of the years that a calendar has"))?;
        self.last_ms = Some(ms);
        Ok(timestamp.to_zoned(TimeZone::UTC).strftime("%Y-%m-%d %H:%M:%S%.3f %j").to_string())
    }

    fn header(&self, step_s: Option<f64>) -> String {
        let interval = match step_s {
            Some(60.0) => "1-minute".to_string(),
            Some(1.0) => "1-second".to_string(),
            Some(step_s) => format!("{step_s} seconds"),
            None => String::new(),
        };
        let labels = [
            ("Format", "IAGA-2002".to_string()),
            ("Source of Data", String::new()),
            ("Station Name", self.code.clone()),
            ("IAGA CODE", self.code.clone()),
            ("Geodetic Latitude", String::new()),
            ("Geodetic Longitude", String::new()),
            ("Elevation", String::new()),
            ("Reported", "XYZF".into()),
            ("Sensor Orientation", "XYZ".into()),
            ("Digital Sampling", step_s.map_or(String::new(), |step_s| format!("{step_s} seconds"))),
            ("Data Interval Type", interval),
            ("Data Type", "variation".into()),
        ];
        let labelled = labels.map(|(label, value)| format!(" {label:<width$}{value}", width = LABEL - 1));
        let comment = " # X, Y, Z corrected with their calibration by fluxcal".to_string();
        let code = &self.code;
        let columns: Vec<String> =
            ["X", "Y", "Z", "F"].map(|letter| format!("{:<10}", format!("{code}{letter}"))).into();
        let titles = format!("DATE       TIME         DOY     {}", columns.concat());
        let lines = labelled.into_iter().chain([comment, titles]);
        lines.map(|line| format!("{:<LINE$}|\n", line.trim_end())).collect()
    }

    /// Gives the file its name.
    pub fn finish(self) -> Result<(), Error> {
        self.sink.finish()
    }
}
