//! Changes to a JSON value of any kind; those that know of recordings are beside.

use serde_json::{Value, json};

use super::{pointers, recordings, values};
use crate::corpus::Corpus;
use crate::draw::Draw;
use crate::kind::FileKind;

/// A key that no version knows.
pub const UNKNOWN: &str = "nobody_knows";

/// Changes by how often they are made.
const CHANGES: [(usize, &str); 24] = [
    (12, "a number replaced"),
    (6, "a number scaled"),
    (8, "a key or item left out"),
    (5, "a value of another type"),
    (4, "a key renamed"),
    (3, "a key that nobody knows"),
    (4, "a word replaced"),
    (7, "a part from another file"),
    (4, "two parts exchanged"),
    (3, "items twice"),
    (3, "a list cut, emptied or shuffled"),
    (1, "deep nesting"),
    (4, "a covariance changed"),
    (5, "a column changed"),
    (3, "times changed"),
    (3, "columns exchanged or copied"),
    (3, "a column's unit changed"),
    (5, "rows cut"),
    (2, "rows repeated"),
    (2, "readings missing"),
    (3, "recordings left out"),
    (3, "a recording twice"),
    (2, "recordings in another order"),
    (4, "a recording's conditions changed"),
];

/// Makes one change, and says which. Absent: none of several could be made.
pub fn edit(value: &mut Value, kind: FileKind, corpus: &Corpus, draw: &mut Draw) -> Option<&'static str> {
    (0..8).find_map(|_| {
        let name = *draw.weighted(&CHANGES);
        change(value, name, (kind, corpus), draw).map(|()| name)
    })
}

/// Makes a change; None where it cannot be made here.
fn change(value: &mut Value, name: &str, (kind, corpus): (FileKind, &Corpus), draw: &mut Draw) -> Option<()> {
    match name {
        "a number replaced" => *some(value, Value::is_number, draw)? = values::number(draw),
        "a number scaled" => {
            let place = some(value, Value::is_number, draw)?;
            let factor = *draw.of(&[-1.0, 0.5, 2.0, 10.0, 1e-3, 1e3, 1e-9, 1e9, 1e100, 1.0001]);
            *place = json!(place.as_f64().unwrap_or_default() * factor);
        }
        "a key or item left out" => {
            let pointer = pointers::pick(value, draw)?;
            let (parent, key) = pointers::parts(&pointer);
            match value.pointer_mut(parent)? {
                Value::Object(map) => drop(map.shift_remove(&key)?),
                Value::Array(list) => drop(list.remove(key.parse().ok()?)),
                _ => return None,
            }
        }
        "a value of another type" => {
            let place = somewhere(value, draw)?;
            *place = values::of_another_type(place, draw);
        }
        "a key renamed" => {
            let pointer = pointers::pick(value, draw)?;
            let (parent, key) = pointers::parts(&pointer);
            let to = match draw.below(3) {
                0 => format!("{key}_x"),
                1 => key.to_uppercase(),
                _ => {
                    let keys = pointers::keys(corpus.any_value(kind, draw)?);
                    keys.keys().nth(draw.below(keys.len()))?.clone()
                }
            };
            pointers::rename(value.pointer_mut(parent)?.as_object_mut()?, &key, to);
        }
        "a key that nobody knows" => {
            let map = somewhere(value, draw)?.as_object_mut()?;
            let inner = values::number(draw);
            let inner = if draw.chance(30) { json!({"deeper": [inner, null, "x"]}) } else { inner };
            map.insert(UNKNOWN.into(), inner);
        }
        "a word replaced" => *some(value, Value::is_string, draw)? = json!(values::word(draw)),
        "a part from another file" => {
            let other = corpus.any_value(kind, draw)?;
            let theirs = pointers::keys(other);
            let (key, places) = theirs.iter().nth(draw.below(theirs.len()))?;
            let part = other.pointer(draw.of(places).as_str()).cloned()?;
            match pointers::keys(value).get(key) {
                Some(places) => *value.pointer_mut(draw.of(places).as_str())? = part,
                // A key of the top that is not here yet.
                None => {
                    other.get(key)?;
                    value.as_object_mut()?.insert(key.clone(), part);
                }
            }
        }
        "two parts exchanged" => {
            let (one, other) = (pointers::pick(value, draw), pointers::pick(value, draw));
            let (one, other) = one.zip(other)?;
            if one.starts_with(&other) || other.starts_with(&one) {
                return None;
            }
            let (a, b) = (value.pointer(&one).cloned()?, value.pointer(&other).cloned()?);
            *value.pointer_mut(&one)? = b;
            *value.pointer_mut(&other)? = a;
        }
        "items twice" => {
            let list = some(value, Value::is_array, draw)?.as_array_mut()?;
            let item = list.get(draw.below(list.len()))?.clone();
            list.insert(draw.below(list.len() + 1), item);
        }
        "a list cut, emptied or shuffled" => {
            let list = some(value, Value::is_array, draw)?.as_array_mut()?;
            match draw.below(4) {
                0 => list.clear(),
                1 => list.truncate(draw.below(list.len())),
                2 => draw.shuffle(list),
                _ => list.reverse(),
            }
        }
        "deep nesting" => {
            let place = somewhere(value, draw)?;
            *place = values::nested(place.take(), draw);
        }
        _ => recordings::change(value, name, draw)?,
    }
    Some(())
}

/// Somewhere in a value, for writing.
fn somewhere<'a>(value: &'a mut Value, draw: &mut Draw) -> Option<&'a mut Value> {
    let pointer = pointers::pick(value, draw)?;
    value.pointer_mut(&pointer)
}

/// What is of some type, somewhere, for writing.
fn some<'a>(value: &'a mut Value, is: fn(&Value) -> bool, draw: &mut Draw) -> Option<&'a mut Value> {
    let pointer = (0..20)
        .filter_map(|_| pointers::pick(value, draw))
        .find(|pointer| value.pointer(pointer).is_some_and(is))?;
    value.pointer_mut(&pointer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// A name that no arm knows would be a change that is never made.
    #[test]
    fn each_change_is_made_of_some_document() {
        let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
        let corpus = Corpus::read(&fixtures).expect("fixtures");
        let kind = FileKind::Document;
        for (_, name) in CHANGES {
            let made = (0..500).any(|case| {
                let draw = &mut Draw::new(1, case);
                let mut value = corpus.any_value(kind, draw).expect("a document").clone();
                change(&mut value, name, (kind, &corpus), draw).is_some()
            });
            assert!(made, "{name}");
        }
    }
}
