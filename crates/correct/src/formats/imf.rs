//! IMFV1.22, minute values as INTERMAGNET's nodes (GINs) distribute them (Technical Reference Manual, appendix on data formats;
//! <https://tech-man.intermagnet.org/stable/appendices/dataformats.html>): days of 24 blocks, each a header and 30
//! lines of two minutes, all of 62 characters and CrLf.

use common::Error;
use std::io::Write;

use super::{About, Format, Row, Rules, SECOND_NS, calendar};

pub const RULES: Rules = Rules { name: "IMF", letters: 3, resolution_ns: 1_000_000 };
const MINUTE_NS: i64 = 60 * SECOND_NS;
const DAY_NS: i64 = 1440 * MINUTE_NS;
/// Tenths of nT.
const MISSING: i64 = 999_999;

/// X, Y, Z and F, tenths of nT. F is of a scalar magnetometer, else missing.
pub struct Imf {
    code: String,
    /// Colatitude and longitude, tenths of a degree in four digits each; nines where they are not known.
    place: String,
    /// Adjusted by baselines, or as reported.
    data_type: char,
    /// The day since 1970 of which minutes are at hand.
    day: Option<i64>,
    minutes: Vec<[i64; 4]>,
}

impl Imf {
    pub fn begin(about: &About) -> Result<Self, Error> {
        if let Some(step_s) = about.step_s.filter(|step_s| (step_s - 60.0).abs() > 1e-3) {
            return Err(Error::Request(format!("found a row each {step_s} s; expected {}", expected())));
        }
        let tenths = |degrees: f64| (10.0 * degrees).round() as i64;
        let place = about.place.map_or("9".repeat(8), |[north, east, _]| {
            format!("{:04}{:04}", tenths(90.0 - north), tenths(east) % 3600)
        });
        let data_type = if about.is_adjusted { 'A' } else { 'R' };
        Ok(Self { code: about.code.clone(), place, data_type, day: None, minutes: Vec::new() })
    }

    /// The day that is at hand, in full.
    fn day(&self, bytes: &mut Vec<u8>) {
        let Some(day) = self.day else { return };
        let date = calendar(day * DAY_NS).strftime("%b%d%y %j").to_string().to_ascii_uppercase();
        let Self { code, place, data_type, .. } = self;
        for (hour, minutes) in self.minutes.chunks_exact(60).enumerate() {
            // "XXX" is an unknown node, and D has no base line; 16 characters are reserved. Writing to a Vec cannot fail.
            let reserve = "R".repeat(16);
            let _ =
                write!(bytes, "{code} {date} {hour:02} XYZF {data_type} XXX {place} 000000 {reserve}\r\n");
            for two in minutes.chunks_exact(2) {
                let [one, other] = [two[0], two[1]].map(|[x, y, z, f]| format!("{x:7} {y:7} {z:7} {f:6}"));
                let _ = write!(bytes, "{one}  {other}\r\n");
            }
        }
    }
}

impl Format for Imf {
    fn row(&mut self, row: &Row, bytes: &mut Vec<u8>) -> Result<(), String> {
        if row.ns % MINUTE_NS != 0 {
            return Err(expected());
        }
        let day = row.ns.div_euclid(DAY_NS);
        if self.day != Some(day) {
            self.day(bytes);
            (self.day, self.minutes) = (Some(day), vec![[MISSING; 4]; 1440]);
        }
        let [x, y, z] = row.field_nt;
        let tenths = |nt: f64| if nt.is_finite() { (10.0 * nt).round() as i64 } else { MISSING };
        let minute = row.ns.rem_euclid(DAY_NS) / MINUTE_NS;
        self.minutes[minute as usize] = [x, y, z, row.scalar_nt.unwrap_or(f64::NAN)].map(tenths);
        Ok(())
    }

    fn end(&mut self, bytes: &mut Vec<u8>) {
        self.day(bytes);
    }
}

/// What rows are expected, and what makes them.
fn expected() -> String {
    "a row each 60 s, centred on the minute; `series resample --step 60` makes them".into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A minute of 2024-03-10, and its field.
    fn minute(minute: i64, x: f64, scalar_nt: Option<f64>) -> Row {
        let ns = (1_710_028_800 + 60 * minute) * SECOND_NS;
        Row { ns, field_nt: [x, -917.34, 42_983.7], scalar_nt }
    }

    fn written(place: Option<[f64; 3]>, rows: &[Row]) -> String {
        let mut bytes = Vec::new();
        let about = About { code: "FLX".into(), place, step_s: Some(60.0), is_adjusted: false };
        let mut format = Imf::begin(&about).expect("begun");
        rows.iter().for_each(|row| format.row(row, &mut bytes).expect("a row"));
        format.end(&mut bytes);
        String::from_utf8(bytes).expect("ASCII")
    }

    #[test]
    fn a_day_is_24_blocks_of_31_lines_of_64_bytes() {
        let text = written(Some([47.93, 15.87, 1087.0]), &[minute(61, 20_054.24, Some(48_552.75))]);
        let lines: Vec<&str> = text.split_inclusive('\n').collect();
        assert_eq!(lines.len(), 24 * 31);
        assert!(lines.iter().all(|line| line.len() == 64 && line.ends_with("\r\n") && line.is_ascii()));
        for (hour, block) in lines.chunks_exact(31).enumerate() {
            let due = format!("FLX MAR1024 070 {hour:02} XYZF R XXX 04210159 000000 RRRRRRRRRRRRRRRR\r\n");
            assert_eq!(block[0], due);
        }
        // Missing minutes are coded as the manual shows it.
        let missing = " 999999  999999  999999 999999";
        assert_eq!(lines[1], format!("{missing}  {missing}\r\n"));
        // 01:01 is the second minute of the second block; fields of 7, 7, 7 and 6 characters.
        assert_eq!(lines[32], format!("{missing}   200542   -9173  429837 485528\r\n"));
        assert_eq!(text.matches("485528").count(), 1);
    }

    #[test]
    fn places_and_scalars_that_are_not_known_are_nines() {
        let text = written(None, &[minute(0, f64::NAN, None)]);
        assert!(text.starts_with("FLX MAR1024 070 00 XYZF R XXX 99999999 000000 "), "{}", &text[..64]);
        assert!(text[64..].starts_with(" 999999   -9173  429837 999999  "), "{}", &text[64..128]);
        // Tenths of degrees at the edges: the pole, and just west of Greenwich.
        assert!(written(Some([90.0, 359.97, 0.0]), &[minute(0, 1.0, None)]).contains(" 00000000 "));
        assert!(written(Some([-90.0, 180.0, 0.0]), &[minute(0, 1.0, None)]).contains(" 18001800 "));
    }

    #[test]
    fn each_day_with_rows_is_whole() {
        let text = written(None, &[minute(1439, 1.0, None), minute(1440, 2.0, None)]);
        assert_eq!(text.len(), 2 * 24 * 31 * 64);
        assert!(text.contains("FLX MAR1024 070 23 ") && text.contains("FLX MAR1124 071 00 "));
    }
}
