//! The JSON of the web service of the USGS for absolute measurements (`baselines/observation.json.php` with
//! `includemeasurements=true`): visits to the pier, each with several measurements of the null method. Each reading
//! has the ordinates h, e, z of the variometer and f of the scalar magnetometer at that moment.

use common::Extra;
use serde_json::Value;
use tables::Place;

use super::Sheet;
use super::row::{Row, VIEWS, complete, moment};
use crate::Error;
use crate::clock::SECOND_NS;
use crate::text::{Source, list, without_blanks};

/// Whether an object is such an answer, by its beginning.
pub fn is_meant(bytes: &[u8]) -> bool {
    let head = without_blanks(bytes);
    head.contains("\"data\":[{") && head.contains("\"readings\":[{")
}

/// Reads the measurements. Errors: what is not such an answer; a measurement without one of its readings.
pub fn read(source: &Source) -> Result<Vec<Sheet>, Error> {
    let object: Value = serde_json::from_slice(&source.bytes).map_err(|error| {
        source.fault(Place::Whole, format!("no JSON ({error})"), "one JSON object; was the file cut?")
    })?;
    let mut sheets = Vec::new();
    for (index, visit) in list(&object["data"]).iter().enumerate() {
        for (number, reading) in list(&visit["readings"]).iter().enumerate() {
            sheets.push(sheet(source, visit, reading, &format!("data[{index}].readings[{number}]"))?);
        }
    }
    Ok(sheets)
}

fn sheet(source: &Source, visit: &Value, reading: &Value, path: &str) -> Result<Sheet, Error> {
    let fault = |found: String, expected: &str| source.fault(Place::Whole, found, expected);
    let mut sheet = Sheet::of(source, "the web service of the USGS");
    let azimuth = &visit["mark"]["azimuth"];
    let Some(degrees) = azimuth.as_f64().filter(|degrees| degrees.abs() <= 360.0) else {
        let found = format!("{azimuth} for the azimuth of the mark of {path}");
        return Err(fault(found, "degrees from geographic north towards east"));
    };
    let serial = |value: &Value| value.get("serial").unwrap_or(value).clone();
    let conditions = [
        ("mark_azimuth_deg", degrees.rem_euclid(360.0).into()),
        ("pillar_difference_nt", visit["pier"]["correction"].clone()),
        ("pillar", visit["pier"]["name"].clone()),
        ("observer", visit["observer"].clone()),
        (super::THEODOLITE, serial(&visit["theodolite"])),
        ("magnetometer", serial(&visit["electronics"])),
        ("components", "hez".into()),
    ];
    put(&mut sheet.conditions, conditions);
    put(&mut sheet.kept, ["id", "set", "D", "H", "Z"].map(|key| (key, reading[key].clone())));
    put(&mut sheet.kept, ["observatory", "reviewer", "reviewed"].map(|key| (key, visit[key].clone())));
    let measurements = list(&reading["measurements"]);
    for (index, measurement) in measurements.iter().enumerate() {
        let row = row(measurement).map_err(|key| {
            let found = format!("{} at {path}.measurements[{index}].{key}", measurement[key]);
            fault(
                found,
                "types as FirstMarkUp or EastDown, angles from 0 to 360, times in seconds since 1970, ordinates in nT",
            )
        })?;
        sheet.rows.extend(row);
    }
    if sheet.rows.iter().all(|row| row.time_ns.is_none()) {
        let expected = "readings with their times; ask the service with includemeasurements=true";
        return Err(fault(format!("{path} without measurements"), expected));
    }
    complete(source, Place::Whole, path, &sheet.rows)?;
    Ok(sheet)
}

fn put<const N: usize>(into: &mut Extra, entries: [(&str, Value); N]) {
    let stated = entries.into_iter().filter(|(_, value)| !value.is_null());
    into.extend(stated.map(|(key, value)| (key.to_string(), value)));
}

/// A measurement, None where the circle was not read; the key that is wrong.
fn row(measurement: &Value) -> Result<Option<Row>, &'static str> {
    let name = measurement["type"].as_str().unwrap_or_default();
    let name = name.trim_start_matches("First").trim_start_matches("Second");
    let view = VIEWS.into_iter().find_map(|view| Some((view, name.strip_prefix(view)?)));
    let (view, face) = view.filter(|(_, face)| ["Up", "Down"].contains(face)).ok_or("type")?;
    let circle = match &measurement["angle"] {
        Value::Null => return Ok(None),
        angle => angle.as_f64().filter(|angle| (0.0..=360.0).contains(angle)).ok_or("angle")?,
    };
    let number = |key: &'static str, absent: f64| match &measurement[key] {
        Value::Null => Ok(absent),
        value => value.as_f64().ok_or(key),
    };
    let mut row = Row::at(view, face == "Up", circle, number("residual", 0.0)?);
    row.time_ns = match &measurement["time"] {
        Value::Null => None,
        Value::String(text) => Some(moment(text).ok_or("time")?),
        time => {
            let seconds = time.as_f64().filter(|seconds| seconds.abs() < 9e9);
            Some((seconds.ok_or("time")? * SECOND_NS as f64).round() as i64)
        }
    };
    for (value, key) in row.values[4..].iter_mut().zip(["f", "h", "e", "z"]) {
        *value = number(key, f64::NAN)?;
    }
    Ok(Some(row))
}
