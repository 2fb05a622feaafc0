use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;

use crate::fixture;

/// How far a number may be from the expected one: |a − b| ≤ absolute + relative |b|.
#[derive(Clone, Copy, Default, Deserialize)]
struct Tolerance {
    #[serde(default)]
    absolute: f64,
    #[serde(default)]
    relative: f64,
}

/// Runs one golden case: the fixture `input` through `run`, against `<case>/expected.json` within the
/// `tolerances.json` of its stage (`default`, and others by the beginning of a JSON path; the longest holds).
/// Its words must be well written ([`crate::ill_written`]). With BLESS=1 in the environment the expected
/// document is written anew: read the difference.
pub fn golden(case: &str, input: &str, run: impl FnOnce(&str) -> String) {
    let folder = fixture(case);
    let found = run(&crate::read_fixture(input));
    let parse = |text: &str| serde_json::from_str::<Value>(text).unwrap_or_else(|e| panic!("{case}: {e}"));
    let texts = words(&parse(&found)).into_iter().filter(|text| text.contains(' '));
    let wrong = texts.flat_map(|text| crate::ill_written(&text)).collect::<Vec<_>>();
    assert!(wrong.is_empty(), "{case}: {wrong:?}");
    if bless() {
        fs::create_dir_all(&folder)
            .and_then(|()| fs::write(folder.join("expected.json"), &found))
            .unwrap_or_else(|e| panic!("{case}: {e}"));
        return;
    }
    let tolerances = crate::read_fixture(&format!("{case}/../tolerances.json"));
    let tolerances: BTreeMap<String, Tolerance> =
        serde_json::from_str(&tolerances).unwrap_or_else(|e| panic!("{case}: tolerances: {e}"));
    let expected = crate::read_fixture(&format!("{case}/expected.json"));
    let mut differences = Vec::new();
    compare("", &parse(&found), &parse(&expected), &tolerances, &mut differences);
    assert!(differences.is_empty(), "{case}:\n{}", differences.join("\n"));
}

fn words(value: &Value) -> Vec<String> {
    match value {
        Value::String(text) => vec![text.clone()],
        Value::Array(all) => all.iter().flat_map(words).collect(),
        Value::Object(all) => {
            all.iter().filter(|(key, _)| *key != "history").flat_map(|(_, value)| words(value)).collect()
        }
        _ => Vec::new(),
    }
}

/// Whether expected files are to be written anew.
pub fn bless() -> bool {
    std::env::var_os("BLESS").is_some()
}

fn compare(
    path: &str,
    found: &Value,
    expected: &Value,
    tolerances: &BTreeMap<String, Tolerance>,
    differences: &mut Vec<String>,
) {
    match (found, expected) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap_or(f64::NAN), b.as_f64().unwrap_or(f64::NAN));
            let own = tolerances.iter().filter(|(prefix, _)| path.starts_with(prefix.as_str()));
            let longest = own.max_by_key(|(prefix, _)| prefix.len()).map(|(_, tolerance)| *tolerance);
            let tolerance = longest.or(tolerances.get("default").copied()).unwrap_or_default();
            if (a - b).abs() > tolerance.absolute + tolerance.relative * b.abs() {
                differences.push(format!("{path}: {a} where {b} is expected"));
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            for (index, (a, b)) in a.iter().zip(b).enumerate() {
                compare(&format!("{path}[{index}]"), a, b, tolerances, differences);
            }
        }
        (Value::Object(a), Value::Object(b)) => {
            for key in a.keys().chain(b.keys().filter(|key| !a.contains_key(*key))) {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                match (a.get(key), b.get(key)) {
                    (Some(a), Some(b)) => compare(&path, a, b, tolerances, differences),
                    (None, _) => differences.push(format!("{path}: missing")),
                    (_, None) => differences.push(format!("{path}: not expected")),
                }
            }
        }
        (a, b) if a == b => {}
        (a, b) => differences.push(format!("{path}: {a} where {b} is expected")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn differences(found: &Value, expected: &Value) -> Vec<String> {
        let tolerances = BTreeMap::from([
            ("default".to_string(), Tolerance { absolute: 0.0, relative: 1e-9 }),
            ("a.b".to_string(), Tolerance { absolute: 0.1, relative: 0.0 }),
        ]);
        let mut differences = Vec::new();
        compare("", found, expected, &tolerances, &mut differences);
        differences
    }

    #[test]
    fn numbers_within_tolerance_and_nothing_else() {
        let expected = json!({"a": {"b": [1.0, 2.0]}, "c": 5.0, "d": "x"});
        assert!(differences(&json!({"a": {"b": [1.05, 2.0]}, "c": 5.0, "d": "x"}), &expected).is_empty());
        assert_eq!(differences(&json!({"a": {"b": [1.2, 2.0]}, "c": 5.1, "d": "y"}), &expected).len(), 3);
        assert_eq!(differences(&json!({"a": {"b": [1.0]}, "c": 5.0, "e": 1}), &expected).len(), 3);
    }
}
