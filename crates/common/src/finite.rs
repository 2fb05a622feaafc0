//! Every number of a result is finite before it is written: JSON has no word for others, and `null` would say
//! that nothing was found. Readings that a program made are such as an instrument gives: others would be
//! refused by whoever reads them.

use std::fmt::Debug;

use crate::{Error, Recording, range};

/// Looks through a result, which `name` stands for in the error.
///
/// # Errors
///
/// The path of the first number that is not finite.
pub fn all_finite(name: &str, result: &dyn Debug) -> Result<(), Error> {
    // Without indentation the text takes a fraction of the time; few results have to be looked at more
    // closely.
    let text = format!("{result:?}");
    if !text.contains("NaN") && !text.contains("inf") {
        return Ok(());
    }
    match first(&format!("{result:#?}")) {
        None => Ok(()),
        Some((path, value)) => Err(Error::Unanswerable(format!(
            "{name}{path} came out as {value}, which is no result: the recordings do not determine it, or a number in them is far \
             from what it stands for. Nothing was written"
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

/// The path and the value of the first number of a type's indented debug text that is not finite. That text
/// names every field as JSON does, a line each, for all types at once.
fn first(text: &str) -> Option<(String, &str)> {
    // The fields and list items that are open, each with its indentation and its name; of lists, how many
    // items there were.
    let mut open: Vec<(usize, String, Option<usize>)> = Vec::new();
    for line in text.lines() {
        let indent = line.len() - line.trim_start().len();
        let line = line.trim_start();
        open.retain(|(at, ..)| *at < indent);
        let (name, value) = match line.split_once(": ") {
            Some((name, value)) if name.chars().all(|c| c.is_alphanumeric() || c == '_') => {
                (Some(format!(".{name}")), value)
            }
            Some((name, value)) if name.starts_with('"') && name.ends_with('"') => {
                (Some(format!(".{}", name.trim_matches('"'))), value)
            }
            _ => (None, line),
        };
        if let Some(value) =
            ["NaN", "inf", "-inf"].into_iter().find(|number| value.trim_end_matches(',') == *number)
        {
            let path: String = open.iter().map(|(_, name, _)| name.as_str()).collect();
            let item = open.last().and_then(|(.., count)| count.map(|count| format!("[{count}]")));
            let own = name.or(item).unwrap_or_default();
            return Some((path + &own, value));
        }
        match name {
            Some(name) => open.push((indent, name, value.ends_with('[').then_some(0))),
            // An item of the list that is open.
            None if !matches!(line, ")" | ")," | "]" | "]," | "}" | "},") => {
                // What stands in an `Option` is no item.
                let mut item = String::new();
                if let Some((.., Some(count))) = open.last_mut() {
                    item = format!("[{count}]");
                    *count += 1;
                }
                if line == "[" {
                    open.push((indent, item, Some(0)));
                }
            }
            None => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use crate::{Calibration, Column, Document, Quantity, Recording, SensorCalibration};

    #[test]
    fn the_place_is_named() {
        let mut calibration = Calibration::default();
        let sensors = calibration.sensors.get_or_insert_default();
        let sensor: &mut SensorCalibration = sensors.entry(crate::Axis::Y).get_or_insert_default();
        sensor.offset_nt = Some(Quantity::new(f64::NAN, 1.0));
        let document = Document { fluxcal: 1, calibration: Some(calibration), ..Document::default() };
        let said = document.to_text().expect_err("refused").to_string();
        assert!(said.starts_with("calibration.sensors.y.offset_nt.value came out as NaN"), "{said}");
        let mut bare = document.clone();
        let sensors = bare.calibration.as_mut().and_then(|calibration| calibration.sensors.as_mut());
        let sensor = sensors.and_then(|sensors| sensors.entry(crate::Axis::Y).as_mut()).expect("a sensor");
        sensor.offset_nt = Some(Quantity::Bare(f64::INFINITY));
        let said = bare.to_text().expect_err("refused").to_string();
        assert!(said.starts_with("calibration.sensors.y.offset_nt came out as inf"), "{said}");
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
        let at =
            |list: Vec<f64>| super::first(&format!("{:#?}", One { name: "NaN", list })).map(|found| found.0);
        assert_eq!(at(vec![1.0, 2.0, f64::INFINITY]), Some(".list[2]".into()));
        assert_eq!(at(vec![1.0]), None);
    }
}
