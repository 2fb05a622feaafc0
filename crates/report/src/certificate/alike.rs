//! Keys elsewhere in the document that look as if they were meant for the certificate.

use common::{Certificate, Document, Extra};
use serde_json::Value;
use strsim::osa_distance as distance;

/// Where the certificate looks for something, and the words of keys that may hold it.
const WORDS: [(&str, &str); 16] = [
    ("item.serial", "serial"),
    ("item.manufacturer", "manufacturer maker"),
    ("customer", "customer client"),
    ("laboratory", "laboratory"),
    ("number", "certificate"),
    ("received", "received receipt"),
    ("calibrated", "calibrated"),
    ("issued", "issued issue"),
    ("sampling", "sampling"),
    ("authorised_by", "authorised authorized operator"),
    ("method.procedure", "procedure"),
    ("traceability", "traceability"),
    ("conditions", "humidity"),
    ("adjustment.done", "adjustment"),
    ("opinions", "opinion"),
    ("deviations", "deviations"),
];

/// The objects of the certificate with their keys, as its schema has them.
const KEYS: [(&str, &str); 9] = [
    ("", CERTIFICATE),
    ("laboratory", PARTY),
    ("customer", PARTY),
    ("item", "description manufacturer model serial condition"),
    ("method", "procedure version"),
    ("adjustment", "done before"),
    ("references", "kind identity certificate issued_by date"),
    ("authorised_by", "name function"),
    ("sampled", "date item location method conditions uncertainty"),
];
const CERTIFICATE: &str = "number laboratory location customer method item received calibrated issued sampling \
    sampled deviations authorised_by external_results customer_data conditions traceability references \
    adjustment opinions agreed_interval";
const PARTY: &str = "name address contact";

/// Of so many letters of a word one may be wrong.
const LETTERS: usize = 4;
/// Words shorter than this are not looked for with a letter wrong.
const LONG: usize = 6;

/// A sentence for each such key: where it stands, and where it belongs.
pub fn notes(document: &Document, data: &Certificate) -> Vec<String> {
    let data = serde_json::to_value(data).unwrap_or_default();
    let mut notes = unknown(&data);
    let mut seen: Vec<(String, &str, usize)> = Vec::new();
    walk_all(document, &mut |path, key| {
        let Some(place) = meant(key).filter(|place| !is_given(&data, place)) else { return };
        match seen.iter_mut().find(|(first, of, _)| *of == place && first.ends_with(&format!(".{key}"))) {
            Some((.., count)) => *count += 1,
            None => seen.push((format!("{path}.{key}").trim_start_matches('.').to_string(), place, 0)),
        }
    });
    notes.extend(seen.into_iter().map(|(path, place, more)| {
        let more = if more > 0 { format!(" (and {more} more)") } else { String::new() };
        format!("`{path}`{more} is not read; is it meant for `certificate.{place}`?")
    }));
    notes
}

/// Keys within `certificate` that it does not know.
fn unknown(data: &Value) -> Vec<String> {
    let mut notes = Vec::new();
    let mut add = |path: &str, part: &Value, known: &str| {
        let is_known = |key: &str| known.split(' ').any(|known| known == key);
        for key in part.as_object().into_iter().flatten().map(|(key, _)| key).filter(|key| !is_known(key)) {
            let near = known.split(' ').min_by_key(|one| distance(key, one));
            let near = near.filter(|one| distance(key, one) <= 2);
            let remedy = near.map_or(String::new(), |one| format!("; is `{one}` meant?"));
            notes.push(format!("`certificate{path}.{key}` is not a key of the certificate{remedy}"));
        }
    };
    for (place, known) in KEYS {
        match (place, &data[place]) {
            ("", _) => add("", data, known),
            (_, Value::Array(list)) => {
                let each = list.iter().enumerate();
                each.for_each(|(number, one)| add(&format!(".{place}[{number}]"), one, known));
            }
            (_, part) => add(&format!(".{place}"), part, known),
        }
    }
    notes
}

/// Every key that no type knows, with the path of what it stands in, outside of `certificate`.
fn walk_all(document: &Document, found: &mut impl FnMut(&str, &str)) {
    walk("", &document.extra, found);
    if let Some(facility) = &document.facility {
        walk("facility", &facility.extra, found);
        for (axis, coil) in facility.coils.iter().flat_map(|coils| coils.iter()) {
            walk(&format!("facility.coils.{axis}"), &coil.extra, found);
        }
        facility.voltmeter.iter().for_each(|one| walk("facility.voltmeter", &one.extra, found));
    }
    document.instrument.iter().for_each(|one| walk("instrument", &one.extra, found));
    for (number, recording) in document.recordings.iter().enumerate() {
        walk(&format!("recordings[{number}]"), &recording.extra, found);
        walk(&format!("recordings[{number}].conditions"), &recording.conditions.extra, found);
    }
    if let Some(calibration) = &document.calibration {
        walk("calibration", &calibration.extra, found);
        for (axis, sensor) in calibration.sensors.iter().flat_map(|sensors| sensors.iter()) {
            walk(&format!("calibration.sensors.{axis}"), &sensor.extra, found);
        }
    }
}

fn walk(path: &str, extra: &Extra, found: &mut impl FnMut(&str, &str)) {
    for (key, value) in extra {
        found(path, key);
        if let Value::Object(inner) = value {
            let path = format!("{path}.{key}");
            walk(path.trim_start_matches('.'), inner, found);
        }
    }
}

/// Where in the certificate a key may belong: one of its words is one of [`WORDS`], or nearly.
fn meant(key: &str) -> Option<&'static str> {
    let key = key.to_lowercase();
    let words: Vec<&str> = key.split(|c: char| !c.is_ascii_alphabetic()).collect();
    let is = |word: &str, known: &str| {
        word == known || (known.len() >= LONG && distance(word, known) <= (known.len() / LETTERS).min(2))
    };
    let is_any = |known: &str| words.iter().any(|word| is(word, known));
    let near = WORDS.iter().find(|(_, known)| known.split(' ').any(is_any));
    near.map(|(place, _)| *place)
}

fn is_given(data: &Value, place: &str) -> bool {
    let has = |path: &str| data.pointer(path).is_some_and(|value| !value.is_null());
    match place {
        "customer" => has("/customer/name"),
        "laboratory" => has("/laboratory/name"),
        "sampling" => has("/sampling") || has("/sampled"),
        "adjustment.done" => has("/adjustment"),
        _ => has(&format!("/{}", place.replace('.', "/"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_that_look_alike() {
        for (key, place) in [
            ("serial_number", Some("item.serial")),
            ("Serial", Some("item.serial")),
            ("serail", Some("item.serial")),
            ("costumer", Some("customer")),
            ("client_name", Some("customer")),
            ("date_of_issue", Some("issued")),
            ("certifcate", Some("number")),
            ("series", None),
            ("turns", None),
            ("weather", None),
        ] {
            assert_eq!(meant(key), place, "{key}");
        }
    }

    #[test]
    fn the_keys_are_those_of_the_schema() {
        let schema: Value =
            serde_json::from_str(include_str!("../../../../schemas/document.schema.json")).expect("JSON");
        let types = "Certificate Party Party CalibratedItem Method Adjustment Reference Person Sampling";
        for (name, (_, keys)) in types.split(' ').zip(KEYS) {
            let there = schema["$defs"][name]["properties"].as_object().expect("properties");
            let mut there: Vec<&str> = there.keys().map(String::as_str).collect();
            let mut keys: Vec<&str> = keys.split(' ').collect();
            there.sort_unstable();
            keys.sort_unstable();
            assert_eq!(keys, there, "{name}");
        }
    }
}
