//! Changes to a JSON value of any kind; those that know of recordings are beside.

use serde_json::{Value, json};

use super::change::{Change, Context};
use super::{columns, pointers, recordings, values};
use crate::corpus::Corpus;
use crate::draw::Draw;
use crate::kind::FileKind;

/// A key that no version knows.
pub const UNKNOWN: &str = "nobody_knows";

/// Changes by how often they are made.
const CHANGES: [(usize, (&str, Change)); 24] = [
    (12, ("a number replaced", number)),
    (6, ("a number scaled", scaled)),
    (8, ("a key or item left out", left_out)),
    (5, ("a value of another type", other_type)),
    (4, ("a key renamed", renamed)),
    (3, ("a key that nobody knows", unknown_key)),
    (4, ("a word replaced", word)),
    (7, ("a part from another file", spliced)),
    (4, ("two parts exchanged", exchanged)),
    (3, ("items twice", twice)),
    (3, ("a list cut, emptied or shuffled", list)),
    (1, ("deep nesting", nested)),
    (4, ("a covariance changed", columns::covariance)),
    (5, ("a column changed", columns::column)),
    (3, ("times changed", columns::times)),
    (3, ("columns exchanged or copied", columns::exchanged)),
    (3, ("a column's unit changed", columns::unit)),
    (5, ("rows cut", columns::rows_cut)),
    (2, ("rows repeated", columns::rows_repeated)),
    (2, ("readings missing", columns::missing)),
    (3, ("recordings left out", recordings::left_out)),
    (3, ("a recording twice", recordings::twice)),
    (2, ("recordings in another order", recordings::permuted)),
    (4, ("a recording's conditions changed", recordings::conditions)),
];

/// Makes one change, and says which. Absent: none of several could be made.
pub fn edit(value: &mut Value, kind: FileKind, corpus: &Corpus, draw: &mut Draw) -> Option<&'static str> {
    let context = Context { corpus, kind };
    (0..8).find_map(|_| {
        let (name, change) = *draw.weighted(&CHANGES);
        change(value, &context, draw).then_some(name)
    })
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

fn number(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> bool {
    let Some(place) = some(value, Value::is_number, draw) else { return false };
    *place = values::number(draw);
    true
}

fn scaled(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> bool {
    let Some(place) = some(value, Value::is_number, draw) else { return false };
    let factor = *draw.of(&[-1.0, 0.5, 2.0, 10.0, 1e-3, 1e3, 1e-9, 1e9, 1e100, 1.0001]);
    *place = json!(place.as_f64().unwrap_or_default() * factor);
    true
}

fn left_out(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> bool {
    let Some(pointer) = pointers::pick(value, draw) else { return false };
    let (parent, key) = pointers::parts(&pointer);
    match value.pointer_mut(parent) {
        Some(Value::Object(map)) => map.shift_remove(&key).is_some(),
        Some(Value::Array(list)) => key.parse().is_ok_and(|index: usize| {
            list.remove(index);
            true
        }),
        _ => false,
    }
}

fn other_type(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> bool {
    let Some(place) = somewhere(value, draw) else { return false };
    *place = values::of_another_type(place, draw);
    true
}

fn renamed(value: &mut Value, context: &Context<'_>, draw: &mut Draw) -> bool {
    let Some(pointer) = pointers::pick(value, draw) else { return false };
    let (parent, key) = pointers::parts(&pointer);
    let to = match draw.below(3) {
        0 => format!("{key}_x"),
        1 => key.to_uppercase(),
        _ => {
            let Some(other) = context.corpus.any_value(context.kind, draw) else { return false };
            let keys = pointers::keys(other);
            let Some(key) = keys.keys().nth(draw.below(keys.len())) else { return false };
            key.clone()
        }
    };
    let Some(Value::Object(map)) = value.pointer_mut(parent) else { return false };
    pointers::rename(map, &key, to);
    true
}

fn unknown_key(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> bool {
    let Some(Value::Object(map)) = somewhere(value, draw) else { return false };
    let inner = values::number(draw);
    let inner = if draw.chance(30) { json!({"deeper": [inner, null, "x"]}) } else { inner };
    map.insert(UNKNOWN.into(), inner);
    true
}

fn word(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> bool {
    let Some(place) = some(value, Value::is_string, draw) else { return false };
    *place = json!(values::word(draw));
    true
}

fn spliced(value: &mut Value, context: &Context<'_>, draw: &mut Draw) -> bool {
    let Some(other) = context.corpus.any_value(context.kind, draw) else { return false };
    let theirs = pointers::keys(other);
    let Some((key, places)) = theirs.iter().nth(draw.below(theirs.len())) else { return false };
    let Some(part) = other.pointer(draw.of(places).as_str()).cloned() else { return false };
    let ours = pointers::keys(value);
    match ours.get(key) {
        Some(places) => {
            let Some(place) = value.pointer_mut(draw.of(places).as_str()) else { return false };
            *place = part;
        }
        // A key of the top that is not here yet.
        None if other.get(key).is_some() => {
            let Value::Object(map) = value else { return false };
            map.insert(key.clone(), part);
        }
        None => return false,
    }
    true
}

fn exchanged(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> bool {
    let (Some(one), Some(other)) = (pointers::pick(value, draw), pointers::pick(value, draw)) else {
        return false;
    };
    if one.starts_with(&other) || other.starts_with(&one) {
        return false;
    }
    let (Some(a), Some(b)) = (value.pointer(&one).cloned(), value.pointer(&other).cloned()) else {
        return false;
    };
    for (place, part) in [(one, b), (other, a)] {
        value.pointer_mut(&place).into_iter().for_each(|place| *place = part.clone());
    }
    true
}

fn twice(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> bool {
    let Some(Value::Array(list)) = some(value, Value::is_array, draw) else { return false };
    if list.is_empty() {
        return false;
    }
    let item = draw.of(list).clone();
    list.insert(draw.below(list.len() + 1), item);
    true
}

fn list(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> bool {
    let Some(Value::Array(list)) = some(value, Value::is_array, draw) else { return false };
    match draw.below(4) {
        0 => list.clear(),
        1 => list.truncate(draw.below(list.len())),
        2 => draw.shuffle(list),
        _ => list.reverse(),
    }
    true
}

fn nested(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> bool {
    let Some(place) = somewhere(value, draw) else { return false };
    *place = values::nested(place.take(), draw);
    true
}
