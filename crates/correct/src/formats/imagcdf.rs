//! ImagCDF 1.2, INTERMAGNET's exchange format in NASA's CDF (Technical Reference Manual, appendix on data formats;
//! <https://tech-man.intermagnet.org/stable/appendices/dataformats.html>): X, Y, Z, and S as the scalar magnetometer
//! read it, at evenly spaced times that all share.

use ingest::tt2000;

use super::cdf::{Cdf, Value, Variable};
use super::{About, Format, LARGEST_NT, Row, Rules};

pub const RULES: Rules = Rules { name: "ImagCDF", letters: 4, resolution_ns: 1 };
/// A value that is missing, an elevation that is not known.
const MISSING: f64 = 99_999.0;
const TIMES: &str = "DataTimes";
/// Records that are written at most, a year of seconds: a variable has to be in one piece, so they are held in memory.
const MOST: f64 = 32e6;
/// What a time may be off its place, in steps: a thousandth of those since the row before, but no more than this.
const OFF: [f64; 2] = [1e-3, 0.05];

pub struct ImagCdf {
    about: About,
    last_ns: i64,
    times: Vec<i64>,
    /// X, Y, Z, S.
    columns: [Vec<f64>; 4],
    has_scalar: bool,
}

impl ImagCdf {
    pub fn begin(about: About) -> Self {
        Self { about, last_ns: 0, times: Vec::new(), columns: Default::default(), has_scalar: false }
    }

    fn push(&mut self, ns: i64, values: [f64; 4]) -> Result<(), String> {
        self.times.push(tt2000(ns).ok_or("a time since 1972, which ImagCDF can hold")?);
        let stored = values.map(|value| if value.is_finite() { value } else { MISSING });
        self.columns.iter_mut().zip(stored).for_each(|(column, value)| column.push(value));
        Ok(())
    }

    fn cdf(&mut self) -> Cdf {
        let letters = if self.has_scalar { "XYZS" } else { "XYZ" };
        let columns = letters.chars().zip(std::mem::take(&mut self.columns));
        let field = |(letter, values): (char, Vec<f64>)| Variable {
            name: format!("GeomagneticField{letter}"),
            records: Value::Doubles(values),
            attributes: of_variable(letter),
        };
        let times = Value::Tt2000(std::mem::take(&mut self.times));
        let times = Variable { name: TIMES.into(), records: times, attributes: Vec::new() };
        let variables = columns.map(field).chain([times]).collect();
        Cdf { attributes: self.of_file(letters), variables }
    }

    /// The attributes that the format demands. There is no clock in what is written, so no date of publication.
    fn of_file(&self, letters: &str) -> Vec<(&'static str, Value)> {
        let text = |text: &str| Value::Text(text.into());
        let [latitude, longitude, elevation] =
            self.about.place.unwrap_or([MISSING; 3]).map(|one| Value::Doubles(vec![one]));
        vec![
            ("FormatDescription", text("INTERMAGNET CDF Format")),
            ("FormatVersion", text("1.2")),
            ("Title", text("Geomagnetic time series data")),
            ("IagaCode", text(&self.about.code)),
            ("ElementsRecorded", text(letters)),
            ("PublicationLevel", text(if self.about.is_adjusted { "2" } else { "1" })),
            ("PublicationDate", Value::Tt2000(vec![i64::MIN])),
            ("ObservatoryName", text(&self.about.code)),
            ("Latitude", latitude),
            ("Longitude", longitude),
            ("Elevation", elevation),
            ("Institution", text("unknown")),
            ("StandardLevel", text("None")),
            ("Source", text("institute")),
        ]
    }
}

fn of_variable(letter: char) -> Vec<(&'static str, Value)> {
    let text = |text: &str| Value::Text(text.into());
    let number = |number: f64| Value::Doubles(vec![number]);
    vec![
        ("FIELDNAM", Value::Text(format!("Geomagnetic Field Element {letter}"))),
        ("UNITS", text("nT")),
        ("FILLVAL", number(MISSING)),
        ("VALIDMIN", number(if letter == 'S' { 0.0 } else { -LARGEST_NT })),
        ("VALIDMAX", number(LARGEST_NT)),
        ("DEPEND_0", text(TIMES)),
        ("DISPLAY_TYPE", text("time_series")),
        ("LABLAXIS", Value::Text(letter.into())),
    ]
}

impl Format for ImagCdf {
    fn row(&mut self, row: &Row, _: &mut Vec<u8>) -> Result<(), String> {
        let since_ns = (row.ns - self.last_ns) as f64;
        if !self.times.is_empty() {
            let step_ns = self.about.step_s.map_or(since_ns, |step_s| 1e9 * step_s);
            let steps = since_ns / step_ns;
            let count = steps.round();
            if count < 1.0 || (steps - count).abs() > OFF[1].min(OFF[0] * count) {
                let expected =
                    "evenly spaced times, apart from gaps, as ImagCDF has them; series resample makes them";
                return Err(expected.into());
            }
            if self.times.len() as f64 + count > MOST {
                let expected =
                    format!("at most {MOST} evenly spaced times, gaps included; series cut makes pieces");
                return Err(expected);
            }
            for gap in 1..count as i64 {
                self.push(self.last_ns + (gap as f64 * step_ns).round() as i64, [f64::NAN; 4])?;
            }
        }
        self.last_ns = row.ns;
        self.has_scalar |= row.scalar_nt.is_some();
        let [x, y, z] = row.field_nt;
        self.push(row.ns, [x, y, z, row.scalar_nt.unwrap_or(f64::NAN)])
    }

    fn end(&mut self, bytes: &mut Vec<u8>) {
        *bytes = self.cdf().bytes();
    }
}

#[cfg(test)]
mod tests {
    use super::super::SECOND_NS;
    use super::*;

    #[test]
    fn variables_and_attributes_are_those_that_the_manual_demands() {
        let about = About { code: "FLX".into(), place: None, step_s: Some(60.0), is_adjusted: false };
        let mut format = ImagCdf::begin(about);
        for (minute, z) in [(0, 3.0), (1, f64::NAN), (4, 4.0)] {
            let ns = (28_500_480 + minute) * 60 * SECOND_NS;
            let row = Row { ns, field_nt: [1.0, 2.0, z], scalar_nt: Some(5.0) };
            format.row(&row, &mut Vec::new()).expect("a row");
        }
        let cdf = format.cdf();
        let names: Vec<&str> = cdf.variables.iter().map(|variable| variable.name.as_str()).collect();
        let fields = ["X", "Y", "Z", "S"].map(|letter| format!("GeomagneticField{letter}"));
        assert_eq!(names, [fields.each_ref().map(String::as_str).as_slice(), &["DataTimes"]].concat());
        let Value::Doubles(z) = &cdf.variables[2].records else { panic!("numbers") };
        assert_eq!(z[..], [3.0, MISSING, MISSING, MISSING, 4.0]);
        let demanded = "FormatDescription FormatVersion Title IagaCode ElementsRecorded PublicationLevel PublicationDate ObservatoryName Latitude Longitude Elevation Institution StandardLevel Source";
        let own = "FIELDNAM UNITS FILLVAL VALIDMIN VALIDMAX DEPEND_0 DISPLAY_TYPE LABLAXIS";
        let named = |list: &[(&str, Value)]| list.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(" ");
        assert_eq!(named(&cdf.attributes), demanded);
        assert!(cdf.variables[..4].iter().all(|variable| named(&variable.attributes) == own));
        assert!(cdf.variables[4].attributes.is_empty());
    }
}
