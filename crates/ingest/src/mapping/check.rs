//! What the types of a mapping do not say: whether it can be followed.

use common::number::bare;
use common::{Error, unit};
use std::collections::HashSet;

use super::{ColumnMapping, FORMATS, Mapping, SourceColumn, TimeMapping};
use crate::clock::{SECOND_NS, Zone};
use crate::units::{self, Conversion};

/// The largest scale or offset: no unit of a reading is so far from those of the document.
const MOST: f64 = 1e12;

impl Mapping {
    /// Reads and checks a mapping.
    ///
    /// # Errors
    ///
    /// What is no mapping or cannot be followed, with its JSON path.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let mapping: Mapping = common::at_path(text)?;
        mapping.check()?;
        Ok(mapping)
    }

    fn check(&self) -> Result<(), Error> {
        let refused = |path: &str, found: String, expected: &str| Err(Error::document(path, found, expected));
        if self.version != 1 {
            let expected = "1, the version that this program knows";
            return refused("fluxcal-mapping", self.version.to_string(), expected);
        }
        if !matches!(self.separator, ',' | ';' | '\t' | '|' | ' ') {
            let expected = "\",\", \";\", \"\\t\", \"|\" or \" \" (any number of blanks)";
            return refused("separator", format!("{:?}", self.separator), expected);
        }
        if !matches!(self.decimal, '.' | ',') || self.decimal == self.separator {
            let found = format!("{:?} beside the separator {:?}", self.decimal, self.separator);
            return refused("decimal", found, "\".\" or \",\", and not the separator");
        }
        if let Some(mark) = self.thousands
            && (!matches!(mark, ',' | '.' | '\'' | '_' | ' ') || mark == self.decimal)
        {
            let found = format!("{mark:?} beside the decimal mark {:?}", self.decimal);
            let expected = "\",\", \".\", \"'\", \"_\" or \" \", and not the decimal mark";
            return refused("thousands", found, expected);
        }
        if self.comment.as_deref() == Some("") {
            return refused("comment", "\"\"".into(), "what comments begin with, or no such key");
        }
        if self.columns.is_empty() {
            return refused("columns", "no column".into(), "at least one column of readings");
        }
        if let Some(time) = &self.time {
            time.check()?;
        }
        let mut sources: HashSet<&SourceColumn> = self.time.iter().flat_map(|time| &time.columns).collect();
        let mut names = HashSet::new();
        for (index, column) in self.columns.iter().enumerate() {
            column.check(&format!("columns[{index}]"))?;
            if !names.insert(column.to.as_str()) {
                let found = format!("{:?}, which another column has already", column.to);
                return refused(&format!("columns[{index}].to"), found, "each name once");
            }
            if !sources.insert(&column.from) {
                let found = format!("{}, which is taken already", column.from);
                return refused(&format!("columns[{index}].from"), found, "each column of the file once");
            }
        }
        Ok(())
    }
}

impl TimeMapping {
    fn check(&self) -> Result<(), Error> {
        let refused = |key: &str, found: String, expected: &str| {
            Err(Error::document(format!("time.{key}"), found, expected))
        };
        match (self.columns.len(), self.step_s) {
            (0, None) => {
                return refused("columns", "no column".into(), "the columns with the time, or `step_s`");
            }
            (_, Some(step_s)) if !(step_s.is_finite() && step_s > 0.0) => {
                return refused("step_s", step_s.to_string(), "seconds above zero");
            }
            (1.., Some(_)) => return refused("step_s", "it beside `columns`".into(), "one of the two"),
            _ => {}
        }
        if self.format == "?" {
            let expected =
                format!("how times are written: {FORMATS}, or a pattern such as %d.%m.%Y %H:%M:%S");
            return refused("format", "\"?\", which is still open".into(), &expected);
        }
        if let Some((before, _, of_day)) = self.of_day() {
            let days = [!before.is_empty(), self.date_in_name.is_some(), self.start.is_some()];
            if days.iter().filter(|said| **said).count() != 1 {
                let expected = format!(
                    "one thing that says the day: a pattern before it, as in \"%Y-%m-%d {of_day}\", or `date_in_name`, or `start`"
                );
                return refused("format", format!("{:?}", self.format), &expected);
            }
        }
        let known = FORMATS.split(", ").any(|word| word == self.format) || self.format.contains('%');
        let needed = self.step_s.is_none() || !self.format.is_empty();
        if needed && !known {
            let expected = format!("{FORMATS}, or a pattern with %");
            return refused("format", format!("{:?}", self.format), &expected);
        }
        if let Some(zone) = &self.zone
            && Zone::parse(zone).is_none()
        {
            let expected = "UTC, an offset such as \"+02:00\", or a name such as \"Europe/Vienna\"";
            return refused("zone", format!("{zone:?}"), expected);
        }
        if let Some(start) = &self.start
            && common::time::Start::parse(start).is_none()
        {
            let expected = "a moment with its offset from UTC, as in \"2024-05-10T00:00:00Z\"";
            return refused("start", format!("{start:?}"), expected);
        }
        Ok(())
    }

    /// What [`TimeMapping::format`] says of a number since midnight: the pattern of the day before it, how
    /// many ns one is, and its word.
    pub fn of_day(&self) -> Option<(&str, i64, &'static str)> {
        let words = [
            ("milliseconds_of_day", SECOND_NS / 1000),
            ("seconds_of_day", SECOND_NS),
            ("hours_of_day", 3600 * SECOND_NS),
        ];
        words.into_iter().find_map(|(word, unit_ns)| {
            let before = self.format.strip_suffix(word)?;
            (before.is_empty() || before.ends_with(' ')).then_some((before.trim_end(), unit_ns, word))
        })
    }

    /// Whose clock it is: UTC where nothing is said.
    pub fn zone(&self) -> Zone {
        self.zone.as_deref().and_then(Zone::parse).unwrap_or(Zone::Fixed(0))
    }
}

impl ColumnMapping {
    fn check(&self, path: &str) -> Result<(), Error> {
        let refused = |key: &str, found: String, expected: &str| {
            Err(Error::document(format!("{path}.{key}"), found, expected))
        };
        let good = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
        if self.to.is_empty() || !self.to.bytes().all(good) || self.to == "time_s" {
            let expected = "a name of letters, digits and _ such as sensor_x_nt; `time_s` comes from `time`";
            return refused("to", format!("{:?}", self.to), expected);
        }
        if let Some(bits) = self.bits.filter(|bits| !(2..=53).contains(bits)) {
            return refused("bits", bits.to_string(), "2 to 53, which a number of double precision holds");
        }
        if let Some([low, high]) = self.valid.filter(|[low, high]| low >= high) {
            let expected = "the least reading before the greatest, in the file's unit";
            return refused("valid", format!("{} to {}", bare(low), bare(high)), expected);
        }
        for (key, number) in [("scale", self.scale), ("offset", self.offset)] {
            let Some(number) = number else { continue };
            if key == "scale" && number == 0.0 || number.abs() > MOST {
                let expected = "a number up to 1e12 in size, for a scale not zero";
                return refused(key, format!("{number:e}"), expected);
            }
        }
        if let Some(sign) = self.sign.filter(|sign| !matches!(sign, 1 | -1)) {
            return refused("sign", sign.to_string(), "1 or -1");
        }
        self.conversion(path).map(drop)
    }

    /// What makes the document's value of the file's; `path` is the column's in errors.
    pub fn conversion(&self, path: &str) -> Result<Conversion, Error> {
        let (sign, offset) = (f64::from(self.sign.unwrap_or(1)), self.offset.unwrap_or(0.0));
        let from = format!("column {}", self.from);
        let refused = |key: &str, found: String, expected: String| {
            Err(Error::document(format!("{path}.{key}"), found, expected))
        };
        let scale = self.scale.unwrap_or(1.0);
        let scaled = Ok(Conversion { factor: sign * scale, offset });
        let target = unit::of_column(&self.to).map(|(_, unit)| unit);
        match (self.unit.as_deref(), target) {
            (Some("?"), _) => {
                let expected = format!("the unit in which the file states it: {}", units::KNOWN);
                refused("unit", format!("\"?\" for {from}, which is still open"), expected)
            }
            (Some(unit), _) if !units::is_known(unit) => {
                refused("unit", format!("the unit {unit:?} for {from}"), format!("one of {}", units::KNOWN))
            }
            (None, None) => scaled,
            (Some("counts"), None) => scaled,
            (Some(unit), None) => {
                let ending = units::ending_for(unit).unwrap_or("nt");
                let expected =
                    format!("a name that ends in a unit, such as {}_{ending}, or no `unit`", self.to);
                refused("to", format!("{:?} for {from} in {unit}", self.to), expected)
            }
            (None, Some(target)) => {
                let expected = format!(
                    "`unit`, the unit in which the file states it; {target} where it is that already"
                );
                refused("unit", format!("no unit for {from}, which becomes {}", self.to), expected)
            }
            (Some(unit), Some(target)) => match (units::conversion(unit, target), self.scale) {
                (Some(conversion), _) => Ok(Conversion {
                    factor: sign * scale * conversion.factor,
                    offset: sign * conversion.offset + offset,
                }),
                (None, Some(_)) => scaled,
                (None, None) => {
                    let found = format!("none for {from}, which becomes {} from {unit}", self.to);
                    refused("scale", found, format!("`scale`: how many {target} one {unit} is"))
                }
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(text: &str) -> Result<Conversion, String> {
        let text = format!("{{\"fluxcal-mapping\": 1, \"columns\": [{text}]}}");
        let mapping = Mapping::parse(&text).map_err(|error| error.to_string())?;
        mapping.columns[0].conversion("columns").map_err(|error| error.to_string())
    }

    #[test]
    fn units_scales_and_signs() {
        let of = |text: &str| column(text).map(|c| (c.factor, c.offset));
        for (text, factor, offset) in [
            (r#"{"from": "x", "to": "sensor_x_nt", "unit": "uT", "sign": -1}"#, -1000.0, 0.0),
            (r#"{"from": 3, "to": "sensor_x_nt", "unit": "counts", "scale": 13.5}"#, 13.5, 0.0),
            (
                r#"{"from": 3, "to": "sensor_x_nt", "unit": "V", "scale": 1e4, "offset": -20680}"#,
                1e4,
                -20680.0,
            ),
            (r#"{"from": "p", "to": "position"}"#, 1.0, 0.0),
        ] {
            assert_eq!(of(text), Ok((factor, offset)));
        }
        for (text, words) in [
            (r#"{"from": "x", "to": "sensor_x_nt"}"#, "no unit"),
            (r#"{"from": "x", "to": "sensor_x", "unit": "V"}"#, "sensor_x_v"),
            (r#"{"from": "x", "to": "time_s", "unit": "s"}"#, "`time_s` comes from `time`"),
            (r#"{"from": "x", "to": "x", "sign": 2}"#, "1 or -1"),
        ] {
            let said = column(text).expect_err(text);
            assert!(said.contains(words), "{text}: {said}");
        }
    }
}
