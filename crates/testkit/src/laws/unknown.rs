//! Keys that no version knows.

use serde_json::{Value, json};

use super::walk::objects;

/// The key; what stands there is no number, column or quantity.
const KEY: &str = "unheard_of";
/// Objects whose keys are data.
const DATA: [&str; 2] = ["columns", "parameters"];

/// The document with such a key in every object, but for those whose keys are data.
pub fn unknown_keys(document: &Value) -> Value {
    let mut asked = document.clone();
    objects(&mut asked, "", &mut |name, object| {
        if !DATA.contains(&name) {
            object.insert(KEY.into(), json!({"of": [name, {"value": null}]}));
        }
    });
    asked
}

/// The document without them.
pub fn without_unknown_keys(document: &Value) -> Value {
    let mut known = document.clone();
    objects(&mut known, "", &mut |_, object| {
        object.remove(KEY);
    });
    known
}

/// Where such a key was and is no longer, though what it stood in is still there as it was, or has only
/// grown. What a stage finds anew (a quantity that is another one without such keys too) takes the place of
/// the old.
pub(super) fn lost(asked: &Value, found: &Value, plain: &Value) -> Vec<String> {
    let mut lost = Vec::new();
    missing("", asked, found, plain, &mut lost);
    lost
}

fn missing(path: &str, asked: &Value, found: &Value, plain: &Value, lost: &mut Vec<String>) {
    match (asked, found) {
        (Value::Object(a), Value::Object(f)) => {
            let anew = a.contains_key("value") && without_unknown_keys(asked) != *plain;
            if a.contains_key(KEY) && a.get(KEY) != f.get(KEY) && !anew {
                lost.push(path.to_string());
            }
            for (key, a) in a.iter().filter(|(key, _)| *key != KEY) {
                if let (Some(f), Some(p)) = (f.get(key), plain.get(key)) {
                    missing(&format!("{path}.{key}"), a, f, p, lost);
                }
            }
        }
        (Value::Array(a), Value::Array(f)) if a.len() <= f.len() => {
            for (place, (a, f)) in a.iter().zip(f).enumerate() {
                missing(&format!("{path}[{place}]"), a, f, &plain[place], lost);
            }
        }
        _ => {}
    }
}
