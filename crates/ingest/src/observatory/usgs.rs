//! The JSON of the USGS web service: one object with `times`, and `values` for each element; D in minutes of
//! arc, missing values null.

use serde_json::Value;
use tables::Place;

use super::Components;
use crate::Error;
use crate::clock::{self, Zone};
use crate::iaga::letter;
use crate::piece::Piece;
use crate::text::{Source, list, without_blanks};

pub fn is_meant(bytes: &[u8]) -> bool {
    without_blanks(bytes).contains("\"type\":\"Timeseries\"")
}

pub fn read(source: &Source, piece: &mut Piece) -> Result<Components, Error> {
    let refused = |found: String, expected: &str| Err(source.fault(Place::Whole, found, expected));
    let object: Value = match serde_json::from_slice(&source.bytes) {
        Ok(object) => object,
        Err(error) => return refused(format!("no JSON ({error})"), "one JSON object; was the file cut?"),
    };
    let about = &object["metadata"]["intermagnet"];
    let times = list(&object["times"]);
    piece.station = Some(about["imo"]["iaga_code"].as_str().unwrap_or_default().to_string());
    piece.lines = (1..=times.len() as u32).collect();
    for (label, value) in [
        ("station name", &about["imo"]["name"]),
        ("data type", &about["data_type"]),
        ("sensor orientation", &about["sensor_orientation"]),
    ] {
        if value.is_string() {
            piece.header.insert(label.into(), value.clone());
        }
    }
    for (row, time) in times.iter().enumerate() {
        let stamp = time.as_str().and_then(|text| clock::iso(text.as_bytes()));
        match stamp.and_then(|stamp| Zone::Fixed(0).moment(stamp).ok()) {
            Some(ns) => piece.times_ns.push(ns),
            None => return refused(format!("times[{row}] {time}"), "a time as in 2014-11-01T00:00:00.000Z"),
        }
    }
    let (mut letters, mut columns) = (Vec::new(), Vec::new());
    for (index, element) in list(&object["values"]).iter().enumerate() {
        let id = element["id"].as_str().unwrap_or_default();
        let Some(letter) = letter(id) else {
            return refused(format!("values[{index}].id {id:?}"), "a component: X, Y, Z, H, D, E, F, …");
        };
        let values = list(&element["values"]);
        if values.len() != times.len() {
            let found = format!("{} values of {id} and {} times", values.len(), times.len());
            return refused(found, "as many values as times");
        }
        if let Some(row) = values.iter().position(|value| !(value.is_null() || value.is_number())) {
            return refused(format!("{} as {id} of row {row}", values[row]), "a number, or null");
        }
        letters.push(letter);
        columns.push(values.iter().map(|value| value.as_f64().unwrap_or(f64::NAN)).collect());
    }
    Ok((letters, columns))
}
