//! IAGA-2002, the exchange format of observatories (IAGA Division V, working group V-DAT;
//! <https://www.ncei.noaa.gov/services/world-data-system/v-dat-working-group/iaga-2002-data-exchange-format>).

use std::io::Write;

use super::{About, Format, Row, Rules, calendar};

pub const RULES: Rules = Rules { name: "IAGA-2002", letters: 4, resolution_ns: 1_000_000 };
const MISSING: f64 = 99_999.0;
/// A component that is not observed.
const NOT_OBSERVED: f64 = 88_888.0;
const LABEL: usize = 24;
const LINE: usize = 69;

/// X, Y, Z, and F as the scalar magnetometer read it.
pub struct Iaga;

impl Iaga {
    pub fn begin(about: &About, bytes: &mut Vec<u8>) -> Self {
        bytes.extend(header(about).bytes());
        Iaga
    }
}

impl Format for Iaga {
    fn row(&mut self, row: &Row, bytes: &mut Vec<u8>) -> Result<(), String> {
        let value = |value: f64| if value.is_finite() { value } else { MISSING };
        let [x, y, z] = row.field_nt.map(value);
        let f = row.scalar_nt.map_or(NOT_OBSERVED, value);
        let moment = calendar(row.ns).strftime("%Y-%m-%d %H:%M:%S%.3f %j").to_string();
        // Writing to a Vec cannot fail.
        let _ = writeln!(bytes, "{moment}    {x:>9.2} {y:>9.2} {z:>9.2} {f:>9.2}");
        Ok(())
    }
}

fn header(about: &About) -> String {
    let About { code, place, step_s, is_adjusted } = about;
    let interval = match step_s {
        Some(60.0) => "1-minute".to_string(),
        Some(1.0) => "1-second".to_string(),
        Some(step_s) => format!("{step_s} seconds"),
        None => String::new(),
    };
    let [latitude, longitude, height] = place.map_or_else(Default::default, |[north, east, height_m]| {
        [format!("{north:.3}"), format!("{east:.3}"), format!("{height_m:.0}")]
    });
    let labels = [
        ("Format", "IAGA-2002".to_string()),
        ("Source of Data", String::new()),
        ("Station Name", code.clone()),
        ("IAGA CODE", code.clone()),
        ("Geodetic Latitude", latitude),
        ("Geodetic Longitude", longitude),
        ("Elevation", height),
        ("Reported", "XYZF".into()),
        ("Sensor Orientation", "XYZ".into()),
        ("Digital Sampling", step_s.map_or(String::new(), |step_s| format!("{step_s} seconds"))),
        ("Data Interval Type", interval),
        ("Data Type", if *is_adjusted { "adjusted" } else { "variation" }.into()),
    ];
    let labelled = labels.map(|(label, value)| format!(" {label:<width$}{value}", width = LABEL - 1));
    let comment = " # X, Y, Z corrected with their calibration by fluxcal".to_string();
    let columns: Vec<String> =
        ["X", "Y", "Z", "F"].map(|letter| format!("{:<10}", format!("{code}{letter}"))).into();
    let titles = format!("DATE       TIME         DOY     {}", columns.concat());
    let lines = labelled.into_iter().chain([comment, titles]);
    lines.map(|line| format!("{:<LINE$}|\n", line.trim_end())).collect()
}
