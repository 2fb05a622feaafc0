//! Numbers of a result that are not finite: JSON has no word for them. Each is written as `null` at its place,
//! and [`Undetermined`] says where and why; the rest of the answer stands. Readings that a program made are
//! such as an instrument gives: others would be refused by whoever reads them.

use serde::{Deserialize, Serialize};
use std::fmt::Debug;

use crate::{Error, Extra, Recording, range};

mod null;
pub(crate) use null::{part, read};

/// Numbers that are `null` in the document because the recordings do not determine them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Undetermined {
    /// The path of the number; that of the list, for several of one list.
    pub path: String,
    /// Why it is not there.
    pub reason: String,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// What is undetermined of a result, which `name` stands for in the paths.
pub(crate) fn undetermined(name: &str, result: &dyn Debug) -> Vec<Undetermined> {
    let list = |path: &str| path.trim_end_matches(|c: char| c.is_ascii_digit() || "[]".contains(c)).len();
    let mut found: Vec<Undetermined> = Vec::new();
    for (path, value) in places(result) {
        let reason = match value.as_str() {
            "inf" => "the recordings set no upper limit",
            "-inf" => "the recordings set no lower limit",
            _ => "the recordings do not determine it",
        };
        let path = format!("{name}{path}");
        match found.last_mut() {
            Some(last) if path.ends_with(']') && path[..list(&path)] == last.path[..list(&last.path)] => {
                last.path.truncate(list(&path));
            }
            _ => found.push(Undetermined { path, reason: reason.into(), extra: Extra::new() }),
        }
    }
    found
}

/// Looks through what has no place for numbers that are undetermined.
///
/// # Errors
///
/// The path of the first number that is not finite.
pub fn all_finite(name: &str, result: &dyn Debug) -> Result<(), Error> {
    match places(result).first() {
        None => Ok(()),
        Some((path, value)) => Err(Error::Unanswerable(format!(
            "{name}{path} came out as {value}, which is no result: a number that it follows from is far from what it stands for. \
             Nothing was written"
        ))),
    }
}

/// Looks through readings, which may be missing.
///
/// # Errors
///
/// The path of the first one that no instrument reads.
pub(crate) fn readings(recordings: &[Recording]) -> Result<(), Error> {
    for (index, recording) in recordings.iter().enumerate() {
        for (name, column) in &recording.columns {
            if let Some(row) = column.first_outside(range::bounds(name)) {
                return Err(Error::Unanswerable(format!(
                    "recordings[{index}].columns.{name}[{row}] came out as {:e} in recording \"{}\", which no instrument reads: a \
                     number that it follows from is far from what it stands for. Nothing was written",
                    column[row], recording.id
                )));
            }
        }
    }
    Ok(())
}

/// The paths and the values of all numbers of a type that are not finite, from its debug text: that names
/// every field as JSON does, for all types at once.
fn places(result: &dyn Debug) -> Vec<(String, String)> {
    // Without indentation the text takes a fraction of the time; few results have to be looked at more
    // closely.
    let text = format!("{result:?}");
    if !text.contains("NaN") && !text.contains("inf") {
        return Vec::new();
    }
    // The fields and list items that are open, each with its indentation and its name; of lists, how many
    // items there were.
    let mut open: Vec<(usize, String, Option<usize>)> = Vec::new();
    let mut found = Vec::new();
    for line in format!("{result:#?}").lines() {
        let indent = line.len() - line.trim_start().len();
        let line = line.trim_start();
        open.retain(|(at, ..)| *at < indent);
        let (name, value) = match line.split_once(": ") {
            Some((name, value)) if name.chars().all(|c| c.is_alphanumeric() || c == '_') => {
                (format!(".{name}"), value)
            }
            Some((name, value)) if name.starts_with('"') && name.ends_with('"') => {
                (format!(".{}", name.trim_matches('"')), value)
            }
            _ if matches!(line, ")" | ")," | "]" | "]," | "}" | "},") => continue,
            // An item of the list that is open; what stands in an `Option` is no item.
            _ => match open.last_mut() {
                Some((.., Some(count))) => {
                    *count += 1;
                    (format!("[{}]", *count - 1), line)
                }
                _ => (String::new(), line),
            },
        };
        let number = value.trim_end_matches(',');
        if ["NaN", "inf", "-inf"].contains(&number) {
            let path: String = open.iter().map(|(_, name, _)| name.as_str()).collect();
            found.push((path + &name, number.to_string()));
        }
        open.push((indent, name, value.ends_with('[').then_some(0)));
    }
    found
}

#[cfg(test)]
mod tests {
    use crate::{Calibration, Column, Document, Quantity, Recording, SensorCalibration};

    #[test]
    fn what_is_undetermined_is_listed_and_read_again() {
        let mut calibration = Calibration::default();
        let sensors = calibration.sensors.get_or_insert_default();
        let sensor: &mut SensorCalibration = sensors.entry(crate::Axis::Y).get_or_insert_default();
        sensor.offset_nt = Some(Quantity::new(1.0, f64::NAN).within([0.5, f64::INFINITY]));
        sensor.sensitivity_nt_per_v = Some(Quantity::Bare(f64::NAN));
        sensor.covariance_order = Some(vec!["sensitivity_nt_per_v".into(), "offset_nt".into()]);
        sensor.covariance = Some(vec![vec![1.0, f64::NAN], vec![f64::NAN, 1.0]]);
        let mut document = Document { fluxcal: 1, calibration: Some(calibration), ..Document::default() };
        let text = document.to_text().expect("written");
        let told = |document: &Document| -> Vec<String> {
            document.undetermined.iter().map(|one| format!("{}: {}", one.path, one.reason)).collect()
        };
        let expected = [
            "calibration.sensors.y.sensitivity_nt_per_v: the recordings do not determine it",
            "calibration.sensors.y.offset_nt.std: the recordings do not determine it",
            "calibration.sensors.y.offset_nt.interval_95[1]: the recordings set no upper limit",
            "calibration.sensors.y.covariance: the recordings do not determine it",
        ];
        assert_eq!(told(&document), expected);
        let mut again = Document::parse(&text).expect("read again");
        let sensor = again.calibration.as_ref().and_then(|calibration| calibration.sensor(crate::Axis::Y));
        let offset = sensor.and_then(|sensor| sensor.offset_nt.as_ref()).expect("an offset");
        assert!(offset.std().is_some_and(f64::is_nan));
        assert_eq!(again.to_text().expect("written again"), text);
        let said = crate::Uncertainty::of(&again).expect_err("needed").to_string();
        assert!(said.starts_with("calibration.sensors.y.sensitivity_nt_per_v: found null"), "{said}");
        // The other parts of a document have no number that is undetermined.
        let orientation = r#"{"fluxcal": 1, "recordings": [{"id": "a", "procedure": "free_run",
            "conditions": {"orientation": [[1, 0, 0], [0, 1, 0], [0, 0, null]]}}]}"#;
        let said = Document::parse(orientation).expect_err("refused").to_string();
        assert!(said.starts_with("recordings[0].conditions.orientation[2][2]: found"), "{said}");
    }

    #[test]
    fn readings_are_such_as_are_read_again() {
        let written = |name: &str, value: f64| {
            let columns = [(name.to_string(), Column::from(vec![f64::NAN, value]))].into_iter().collect();
            let recording = Recording { id: "sweep".into(), columns, ..Recording::default() };
            Document { fluxcal: 1, recordings: vec![recording], ..Document::default() }.to_text()
        };
        let said = written("sensor_x_v", 4e34).expect_err("refused").to_string();
        assert!(
            said.starts_with("recordings[0].columns.sensor_x_v[1] came out as 4e34 in recording \"sweep\""),
            "{said}"
        );
        assert!(written("time_s", f64::INFINITY).is_err());
        assert!(written("sensor_x_v", 5.0).is_ok() && written("time_s", 1e300).is_ok());
    }

    #[test]
    fn items_are_counted() {
        #[derive(Debug)]
        struct One {
            #[expect(dead_code, reason = "only its debug text is read")]
            name: &'static str,
            #[expect(dead_code, reason = "only its debug text is read")]
            list: Vec<f64>,
        }
        let at = |list: Vec<f64>| -> Vec<String> {
            super::places(&One { name: "NaN", list }).into_iter().map(|(path, _)| path).collect()
        };
        assert_eq!(at(vec![1.0, f64::NAN, 2.0, f64::INFINITY]), [".list[1]", ".list[3]"]);
        assert!(at(vec![1.0]).is_empty());
    }
}
