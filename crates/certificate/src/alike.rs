//! Keys elsewhere in the document that look as if they were meant for the certificate.

use common::{Certificate, Document, Extra};
use serde_json::Value;
use strsim::osa_distance as distance;

/// A word of a key, and where the certificate looks for what it may hold.
const WORDS: [(&str, &str); 22] = [
    ("serial", "item.serial"),
    ("manufacturer", "item.manufacturer"),
    ("maker", "item.manufacturer"),
    ("customer", "customer"),
    ("client", "customer"),
    ("laboratory", "laboratory"),
    ("certificate", "number"),
    ("received", "received"),
    ("receipt", "received"),
    ("calibrated", "calibrated"),
    ("issued", "issued"),
    ("issue", "issued"),
    ("sampling", "sampling"),
    ("authorised", "authorised_by"),
    ("authorized", "authorised_by"),
    ("operator", "authorised_by"),
    ("procedure", "method.procedure"),
    ("traceability", "traceability"),
    ("humidity", "conditions"),
    ("adjustment", "adjustment.done"),
    ("opinion", "opinions"),
    ("deviations", "deviations"),
];

/// The keys of the certificate's types, as its schema has them.
const TOP: [&str; 21] = [
    "number",
    "laboratory",
    "location",
    "customer",
    "method",
    "item",
    "received",
    "calibrated",
    "issued",
    "sampling",
    "sampled",
    "deviations",
    "authorised_by",
    "external_results",
    "customer_data",
    "conditions",
    "traceability",
    "references",
    "adjustment",
    "opinions",
    "agreed_interval",
];
const PARTY: [&str; 3] = ["name", "address", "contact"];
const METHOD: [&str; 2] = ["procedure", "version"];
const ITEM: [&str; 5] = ["description", "manufacturer", "model", "serial", "condition"];
const REFERENCE: [&str; 5] = ["kind", "identity", "certificate", "issued_by", "date"];
const ADJUSTMENT: [&str; 2] = ["done", "before"];
const PERSON: [&str; 2] = ["name", "function"];
const SAMPLING: [&str; 6] = ["date", "item", "location", "method", "conditions", "uncertainty"];

/// Of so many letters of a word one may be wrong.
const LETTERS: usize = 4;
/// Words shorter than this are not looked for with a letter wrong.
const LONG: usize = 6;

/// A sentence for each such key: where it stands, and where it belongs.
pub fn notes(document: &Document, data: &Certificate) -> Vec<String> {
    let mut notes = unknown(data);
    let mut seen: Vec<(String, &str, usize)> = Vec::new();
    walk_all(document, &mut |path, key| {
        let Some(place) = meant(key).filter(|place| !is_given(data, place)) else { return };
        let name = key.to_string();
        match seen.iter_mut().find(|(first, of, _)| *of == place && first.ends_with(&format!(".{name}"))) {
            Some((.., count)) => *count += 1,
            None => seen.push((format!("{path}.{name}").trim_start_matches('.').to_string(), place, 0)),
        }
    });
    notes.extend(seen.into_iter().map(|(path, place, more)| {
        let more = if more > 0 { format!(" (and {more} more)") } else { String::new() };
        format!("`{path}`{more} is not read; is it meant for `certificate.{place}`?")
    }));
    notes
}

/// Keys within `certificate` that it does not know.
fn unknown(data: &Certificate) -> Vec<String> {
    let part = |path: &str, extra: Option<&Extra>, known: &[&str]| -> Vec<String> {
        let keys = extra.into_iter().flat_map(|extra| extra.keys());
        let sentence = |key: &String| {
            let near =
                known.iter().min_by_key(|one| distance(key, one)).filter(|one| distance(key, one) <= 2);
            let remedy = near.map_or(String::new(), |one| format!("; is `{one}` meant?"));
            format!("`{path}.{key}` is not a key of the certificate{remedy}")
        };
        keys.map(sentence).collect()
    };
    let mut all = part("certificate", Some(&data.extra), &TOP);
    all.extend(part("certificate.laboratory", data.laboratory.as_ref().map(|one| &one.extra), &PARTY));
    all.extend(part("certificate.customer", data.customer.as_ref().map(|one| &one.extra), &PARTY));
    all.extend(part("certificate.item", data.item.as_ref().map(|one| &one.extra), &ITEM));
    all.extend(part("certificate.method", data.method.as_ref().map(|one| &one.extra), &METHOD));
    all.extend(part("certificate.adjustment", data.adjustment.as_ref().map(|one| &one.extra), &ADJUSTMENT));
    for (number, one) in data.references.iter().flatten().enumerate() {
        all.extend(part(&format!("certificate.references[{number}]"), Some(&one.extra), &REFERENCE));
    }
    for (number, one) in data.authorised_by.iter().flatten().enumerate() {
        all.extend(part(&format!("certificate.authorised_by[{number}]"), Some(&one.extra), &PERSON));
    }
    for (number, one) in data.sampled.iter().flatten().enumerate() {
        all.extend(part(&format!("certificate.sampled[{number}]"), Some(&one.extra), &SAMPLING));
    }
    all
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
    let near = WORDS.iter().find(|(known, _)| words.iter().any(|word| is(word, known)));
    near.map(|(_, place)| *place)
}

/// Whether the certificate has what belongs there.
fn is_given(data: &Certificate, place: &str) -> bool {
    let item = data.item.as_ref();
    match place {
        "item.serial" => item.is_some_and(|item| item.serial.is_some()),
        "item.manufacturer" => item.is_some_and(|item| item.manufacturer.is_some()),
        "customer" => data.customer.as_ref().is_some_and(|one| one.name.is_some()),
        "laboratory" => data.laboratory.as_ref().is_some_and(|one| one.name.is_some()),
        "number" => data.number.is_some(),
        "received" => data.received.is_some(),
        "calibrated" => data.calibrated.is_some(),
        "issued" => data.issued.is_some(),
        "sampling" => data.sampling.is_some() || data.sampled.is_some(),
        "authorised_by" => data.authorised_by.is_some(),
        "method.procedure" => data.method.as_ref().is_some_and(|one| one.procedure.is_some()),
        "traceability" => data.traceability.is_some(),
        "conditions" => data.conditions.is_some(),
        "adjustment.done" => data.adjustment.is_some(),
        "opinions" => data.opinions.is_some(),
        _ => data.deviations.is_some(),
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
            serde_json::from_str(include_str!("../../../schemas/document.schema.json")).expect("JSON");
        for (name, keys) in [
            ("Certificate", &TOP[..]),
            ("Party", &PARTY),
            ("Method", &METHOD),
            ("CalibratedItem", &ITEM),
            ("Reference", &REFERENCE),
            ("Adjustment", &ADJUSTMENT),
            ("Person", &PERSON),
            ("Sampling", &SAMPLING),
        ] {
            let there = schema["$defs"][name]["properties"].as_object().expect("properties");
            let mut there: Vec<&str> = there.keys().map(String::as_str).collect();
            let mut keys = keys.to_vec();
            there.sort_unstable();
            keys.sort_unstable();
            assert_eq!(keys, there, "{name}");
        }
    }
}
