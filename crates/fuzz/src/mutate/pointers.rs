//! Places in a JSON value.

use serde_json::{Map, Value};
use std::collections::BTreeMap;

use crate::draw::Draw;

/// A place: along a way down from the top, or under a key of its own, so that rare keys come up as often as
/// common ones.
pub fn pick(value: &Value, draw: &mut Draw) -> Option<String> {
    if draw.chance(60) {
        return walk(value, draw);
    }
    let all = keys(value);
    let (_, places) = all.iter().nth(draw.below(all.len()))?;
    Some(draw.of(places).clone())
}

/// A place with its key, which is the last part of a pointer.
pub fn parts(pointer: &str) -> (&str, String) {
    let (parent, key) = pointer.rsplit_once('/').unwrap_or(("", ""));
    (parent, key.replace("~1", "/").replace("~0", "~"))
}

/// The pointer of a child.
pub fn below(pointer: &str, key: &str) -> String {
    format!("{pointer}/{}", key.replace('~', "~0").replace('/', "~1"))
}

fn walk(value: &Value, draw: &mut Draw) -> Option<String> {
    let mut pointer = String::new();
    let mut at = value;
    loop {
        let (key, child) = match at {
            Value::Object(map) => {
                let (key, child) = map.iter().nth(draw.below(map.len()))?;
                (key.clone(), child)
            }
            Value::Array(list) => {
                let index = draw.below(list.len());
                (index.to_string(), list.get(index)?)
            }
            _ => return None,
        };
        pointer = below(&pointer, &key);
        at = child;
        let is_leaf = match at {
            Value::Object(map) => map.is_empty(),
            Value::Array(list) => list.is_empty(),
            _ => true,
        };
        if is_leaf || draw.chance(22) {
            return Some(pointer);
        }
    }
}

/// All keys, each with its places.
pub fn keys(value: &Value) -> BTreeMap<String, Vec<String>> {
    let mut all = BTreeMap::new();
    collect(value, "", &mut all);
    all
}

fn collect(value: &Value, pointer: &str, all: &mut BTreeMap<String, Vec<String>>) {
    match value {
        Value::Object(map) => {
            for (key, child) in map {
                let place = below(pointer, key);
                collect(child, &place, all);
                all.entry(key.clone()).or_default().push(place);
            }
        }
        Value::Array(list) if list.iter().any(|item| item.is_object() || item.is_array()) => {
            for (index, child) in list.iter().enumerate() {
                collect(child, &format!("{pointer}/{index}"), all);
            }
        }
        _ => {}
    }
}

/// Another key, in its place.
pub fn rename(map: &mut Map<String, Value>, from: &str, to: String) {
    let entries = std::mem::take(map);
    *map =
        entries.into_iter().map(|(key, value)| (if key == from { to.clone() } else { key }, value)).collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_place_is_there() {
        let value = json!({"a": {"b/c": [1, {"d": 2}]}, "e": [], "f": 1.5});
        let mut draw = Draw::new(1, 1);
        for _ in 0..200 {
            let place = pick(&value, &mut draw).expect("a place");
            assert!(value.pointer(&place).is_some(), "{place}");
        }
        assert_eq!(parts("/a/b~1c"), ("/a", "b/c".to_string()));
        assert_eq!(keys(&value)["d"], ["/a/b~1c/1/d"]);
        assert!(pick(&json!({}), &mut draw).is_none());
    }
}
