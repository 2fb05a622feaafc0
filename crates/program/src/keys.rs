//! Keys of a document that no program knows and that resemble one: they are kept, and told, since what was meant
//! by them is not read.

use serde_json::Value;
use serde_json::value::RawValue;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

/// The keys that programs know, as the document's types have them.
static SCHEMA: LazyLock<Value> = LazyLock::new(|| {
    serde_json::from_str(include_str!("../../../schemas/document.schema.json")).expect("a schema")
});
/// The share of the letters, or of the words of two keys, that is alike where one was meant by the other.
const LETTERS: f64 = 0.75;
const WORDS: f64 = 0.66;

/// The first path of each key that is not known and resembles one that is, by the key and what was perhaps
/// meant.
type Mistaken = BTreeMap<(String, &'static str), String>;

/// A line for each key of a document's text that is not known and resembles one that is, once for each key.
pub fn mistaken(text: &str) -> Vec<String> {
    let mut found = Mistaken::new();
    if let Ok(document) = serde_json::from_str(text) {
        walk(document, &[&SCHEMA], "", &mut found);
    }
    let line =
        |((_, known), path)| format!("{path} is a key that no program knows; {known} was perhaps meant");
    found.into_iter().map(line).collect()
}

/// Looks through a value, by the schemas that it may have.
fn walk(value: &RawValue, schemas: &[&'static Value], path: &str, found: &mut Mistaken) {
    let schemas: Vec<&'static Value> = schemas.iter().flat_map(|schema| forms(schema)).collect();
    let of = |key: &'static str| schemas.iter().filter_map(move |schema| schema.get(key));
    let properties = || of("properties").filter_map(Value::as_object);
    let items: Vec<&'static Value> = of("items")
        .filter(|items| forms(items).iter().any(|form| form.get("properties").is_some()))
        .collect();
    if !items.is_empty() {
        let list: Vec<&RawValue> = serde_json::from_str(value.get()).unwrap_or_default();
        let each = list.into_iter().enumerate();
        each.for_each(|(index, value)| walk(value, &items, &format!("{path}[{index}]"), found));
    }
    let others: Vec<&'static Value> = of("additionalProperties").filter(|other| other.is_object()).collect();
    if others.is_empty() && properties().next().is_none() {
        return;
    }
    let entries: BTreeMap<String, &RawValue> = serde_json::from_str(value.get()).unwrap_or_default();
    let absent = || properties().flat_map(|known| known.keys()).filter(|key| !entries.contains_key(*key));
    for (key, value) in &entries {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        let known: Vec<&'static Value> = properties().filter_map(|known| known.get(key)).collect();
        if !known.is_empty() {
            walk(value, &known, &path, found);
        } else if !others.is_empty() {
            walk(value, &others, &path, found);
        } else if let Some(meant) = nearest(key, absent()) {
            found.entry((key.clone(), meant)).or_insert(path);
        }
    }
}

/// The forms that a schema allows, without references.
fn forms(schema: &'static Value) -> Vec<&'static Value> {
    let referred = schema.get("$ref").and_then(|path| SCHEMA.pointer(path.as_str()?.strip_prefix('#')?));
    let choices = ["anyOf", "oneOf", "allOf"].into_iter().filter_map(|key| schema.get(key)?.as_array());
    let inner: Vec<&'static Value> = choices.flatten().chain(referred).flat_map(forms).collect();
    inner.into_iter().chain([schema]).collect()
}

/// The known key that another one resembles most, where it resembles one.
fn nearest(key: &str, known: impl Iterator<Item = &'static String>) -> Option<&'static str> {
    let alike = known.filter_map(|known| {
        let letters = strsim::normalized_damerau_levenshtein(key, known);
        let words = shared(key, known);
        (letters >= LETTERS || words >= WORDS).then_some((known, letters.max(words)))
    });
    alike.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(known, _)| known.as_str())
}

/// The share of the words of two keys that both have; a single word, such as a unit, says nothing.
fn shared(a: &str, b: &str) -> f64 {
    let [a, b] = [a, b].map(|key| key.split('_').collect::<BTreeSet<&str>>());
    let both = a.intersection(&b).count();
    if both < 2 { 0.0 } else { both as f64 / a.union(&b).count() as f64 }
}

#[cfg(test)]
mod tests {
    use super::mistaken;

    #[test]
    fn keys_that_were_meant_are_told_once() {
        let text = r#"{"fluxcal": 1, "titel": "a", "mood": "fair", "instrument": {"name": "A", "names": "B",
            "noise": {"x": {"white_nt": 0.1}, "y": {"white_nt": 0.1}}}, "facility": {"roof": "tin", "theodolite_arcsecs": 1},
            "recordings": [{"id": "a", "procedure": "free_run", "conditions": {"site": "b", "ambient_x_nt": 1, "orientaton": []},
                "columns": {"tims_s": [1]}}],
            "model": {"effects": [{"effect": "e", "found_by": "x", "parameters": {"valu": {"value": 1, "stdd": 2}}}]}}"#;
        let expected = [
            "recordings[0].conditions.orientaton is a key that no program knows; orientation was perhaps meant",
            "model.effects[0].parameters.valu.stdd is a key that no program knows; std was perhaps meant",
            "facility.theodolite_arcsecs is a key that no program knows; theodolite_arcsec was perhaps meant",
            "titel is a key that no program knows; title was perhaps meant",
            "instrument.noise.x.white_nt is a key that no program knows; white_rms_nt was perhaps meant",
        ];
        assert_eq!(mistaken(text), expected);
    }
}
