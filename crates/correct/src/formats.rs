//! Corrected fields in observatory formats. [`Written`] checks what all of them need, the station's code, the
//! start, the times and the size of the field, once; a [`Format`] makes bytes of rows.

mod cdf;
mod iaga;
pub(crate) mod ibf;
mod imagcdf;
mod imf;

use common::time::Start;
use common::{Axis, Error, Recording};
use jiff::tz::TimeZone;
use jiff::{SignedDuration, Timestamp, Zoned};
use std::path::Path;

use crate::Corrected;
use crate::noise::length_and_step_s;
use program::pipe::Sink;

/// Beyond this, nT, the formats have codes of what is missing or not observed, 88 888 and 99 999.
const LARGEST_NT: f64 = 88_880.0;
const SECOND_NS: i64 = 1_000_000_000;

/// A format of observatories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observatory {
    /// IAGA-2002.
    Iaga,
    /// INTERMAGNET's minute values, IMFV1.22.
    Imf,
    /// INTERMAGNET's ImagCDF 1.2.
    ImagCdf,
}

/// For whom a file is written, and in which format.
#[derive(Clone, Copy, Debug)]
pub struct Station<'a> {
    /// The format.
    pub format: Observatory,
    /// The station's code, three letters or digits; in IAGA-2002 and ImagCDF four are possible.
    pub code: &'a str,
    /// When `time_s` is zero, RFC 3339, where the recording does not say it.
    pub start: Option<&'a str>,
    /// Degrees north and east, and metres above the ellipsoid.
    pub place: Option<[f64; 3]>,
}

/// What headers say.
#[derive(Clone)]
struct About {
    code: String,
    /// Degrees north, degrees east from 0 to 360, metres.
    place: Option<[f64; 3]>,
    /// From one row to the next; None where there is one row, or none so far.
    step_s: Option<f64>,
    /// Whether baselines were adopted for the data.
    is_adjusted: bool,
}

/// X north, Y east, Z down, nT; NaN where there is no field.
struct Row {
    /// Since 1970, UTC.
    ns: i64,
    field_nt: [f64; 3],
    /// As the scalar magnetometer read it; None without one.
    scalar_nt: Option<f64>,
}

struct Rules {
    name: &'static str,
    /// Letters of a station's code at most.
    letters: usize,
    resolution_ns: i64,
}

trait Format {
    /// The next row. Errors say what is expected.
    fn row(&mut self, row: &Row, bytes: &mut Vec<u8>) -> Result<(), String>;
    /// What stands after the last one.
    fn end(&mut self, _bytes: &mut Vec<u8>) {}
}

impl Observatory {
    fn rules(self) -> Rules {
        match self {
            Observatory::Iaga => iaga::RULES,
            Observatory::Imf => imf::RULES,
            Observatory::ImagCdf => imagcdf::RULES,
        }
    }

    /// The format, and what stands before the rows.
    fn begin(self, about: &About, bytes: &mut Vec<u8>) -> Result<Box<dyn Format>, Error> {
        Ok(match self {
            Observatory::Iaga => Box::new(iaga::Iaga::begin(about, bytes)),
            Observatory::Imf => Box::new(imf::Imf::begin(about)?),
            Observatory::ImagCdf => Box::new(imagcdf::ImagCdf::begin(about.clone())),
        })
    }
}

pub struct Written {
    sink: Sink,
    observatory: Observatory,
    about: About,
    /// When `time_s` is zero, since 1970.
    start_ns: i64,
    last_ns: Option<i64>,
    count: u64,
    /// There from the first row on.
    format: Option<Box<dyn Format>>,
}

impl Written {
    /// Opens a file, or standard output.
    /// Errors: an invalid code; a recording without `start`; a file that cannot be written.
    pub fn create(
        output: Option<&Path>,
        station: Station<'_>,
        recording: &Recording,
        is_adjusted: bool,
    ) -> Result<Self, Error> {
        let rules = station.format.rules();
        let code = station_code(station.code, rules.letters)?;
        let told = station.start.map(|text| {
            let expected = "--start is not a time; expected RFC 3339, as in 2026-05-26T14:44:35Z";
            Start::parse(text).ok_or_else(|| Error::Request(format!("\"{text}\" after {expected}")))
        });
        let Some(start) = told.transpose()?.or(recording.start()) else {
            let unknown = "needs dates, and the origin of time_s is unknown; give --start, or --recording with a start in the document";
            return Err(Error::Request(format!("{} {unknown}", rules.name)));
        };
        let place = station.place.map(|[north, east, height_m]| [north, east.rem_euclid(360.0), height_m]);
        Ok(Self {
            sink: Sink::open(output)?,
            observatory: station.format,
            about: About { code, place, step_s: None, is_adjusted },
            start_ns: (start.unix_s * 1e6).round() as i64 * 1000,
            last_ns: None,
            count: 0,
            format: None,
        })
    }

    /// Writes rows. False: the reader of standard output has gone.
    /// Errors: rows without a time, out of order, or as the format cannot hold them.
    pub fn write(&mut self, recording: &Recording, corrected: &Corrected) -> Result<bool, Error> {
        let rules = self.observatory.rules();
        let Some(times) = recording.column("time_s") else {
            let words = format!("found no column time_s; {} has a time in each row", rules.name);
            return Err(Error::Request(words));
        };
        let mut bytes = Vec::new();
        let mut format = match self.format.take() {
            Some(format) => format,
            None => {
                self.about.step_s = length_and_step_s(times).map(|[_, step_s]| step_s);
                self.observatory.begin(&self.about, &mut bytes)?
            }
        };
        let scalar = recording.column("reference_nt");
        for (row, time_s) in times.iter().enumerate() {
            self.count += 1;
            let found = |found: String, expected: &str| {
                Error::Request(format!("row {}: found {found}; expected {expected}", self.count))
            };
            let ns =
                self.moment(*time_s).map_err(|expected| found(format!("time_s = {time_s}"), &expected))?;
            let field_nt = Axis::ALL.map(|axis| corrected.field_nt[axis.index()][row]);
            let scalar_nt = scalar.map(|column| column[row]);
            let too_large = field_nt.iter().copied().find(|value| value.abs() > LARGEST_NT);
            let no_length = scalar_nt.filter(|value| *value < 0.0 || *value > LARGEST_NT);
            if let Some(value) = too_large.or(no_length) {
                let expected = format!(
                    "a field within ±{LARGEST_NT} nT and a reference_nt that is not negative, which {} can hold; write a table (-o field.csv)",
                    rules.name
                );
                return Err(found(format!("{value} nT"), &expected));
            }
            format
                .row(&Row { ns, field_nt, scalar_nt }, &mut bytes)
                .map_err(|expected| found(format!("time_s = {time_s}"), &expected))?;
            self.last_ns = Some(ns);
        }
        self.format = Some(format);
        self.sink.write(&bytes)
    }

    /// The stamp of a row, to the format's resolution; else what is expected.
    fn moment(&self, time_s: f64) -> Result<i64, String> {
        let Rules { name, resolution_ns: resolution, .. } = self.observatory.rules();
        let since = (time_s.abs() < 9e9).then(|| (time_s * 1e9).round() as i64);
        let ns = since.and_then(|since| self.start_ns.checked_add(since));
        // The years of the calendar of 64 bits, without its ends.
        let ns = ns.filter(|ns| ns.unsigned_abs() < 9_200_000_000_000_000_000);
        let ns = ns.map(|ns| (ns + resolution / 2).div_euclid(resolution) * resolution);
        let ns = ns.filter(|ns| self.last_ns.is_none_or(|last| *ns > last));
        let least = if resolution < 1_000_000 { "1 ns" } else { "1 ms" };
        ns.ok_or_else(|| {
            format!("times that increase by at least {least}, the resolution of {name}, from 1678 to 2261")
        })
    }

    /// Writes what is left, and gives the file its name.
    pub fn finish(mut self) -> Result<(), Error> {
        let Some(format) = self.format.as_mut().filter(|_| self.count > 0) else {
            let name = self.observatory.rules().name;
            return Err(Error::Request(format!("found no rows; expected one at least for {name}")));
        };
        let mut bytes = Vec::new();
        format.end(&mut bytes);
        if self.sink.write(&bytes)? { self.sink.finish() } else { Ok(()) }
    }
}

/// A station's code in capitals.
fn station_code(code: &str, letters: usize) -> Result<String, Error> {
    if (3..=letters).contains(&code.len()) && code.bytes().all(|byte| byte.is_ascii_alphanumeric()) {
        return Ok(code.to_ascii_uppercase());
    }
    let count = if letters == 3 { "three" } else { "three or four" };
    Err(Error::Request(format!("\"{code}\" is not a station code; expected {count} letters or digits")))
}

/// The calendar's time of a stamp, ns since 1970.
pub(crate) fn calendar(ns: i64) -> Zoned {
    let since = SignedDuration::from_nanos(ns);
    Timestamp::from_duration(since).unwrap_or_default().to_zoned(TimeZone::UTC)
}
