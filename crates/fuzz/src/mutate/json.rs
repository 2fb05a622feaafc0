//! Changes to a JSON value of any kind; those that know of recordings are beside.

use serde_json::{Value, json};

use super::{columns, pointers, recordings, values};
use crate::corpus::{Context, Corpus};
use crate::draw::Draw;
use crate::kind::FileKind;

/// A key that no version knows.
pub const UNKNOWN: &str = "nobody_knows";

/// A change; None where it cannot be made here.
type Change = fn(&mut Value, &Context<'_>, &mut Draw) -> Option<()>;

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
        change(value, &context, draw).map(|()| name)
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

fn number(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    *some(value, Value::is_number, draw)? = values::number(draw);
    Some(())
}

fn scaled(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let place = some(value, Value::is_number, draw)?;
    let factor = *draw.of(&[-1.0, 0.5, 2.0, 10.0, 1e-3, 1e3, 1e-9, 1e9, 1e100, 1.0001]);
    *place = json!(place.as_f64().unwrap_or_default() * factor);
    Some(())
}

fn left_out(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let pointer = pointers::pick(value, draw)?;
    let (parent, key) = pointers::parts(&pointer);
    match value.pointer_mut(parent) {
        Some(Value::Object(map)) => map.shift_remove(&key).map(drop),
        Some(Value::Array(list)) => key.parse().ok().map(|index: usize| drop(list.remove(index))),
        _ => None,
    }
}

fn other_type(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let place = somewhere(value, draw)?;
    *place = values::of_another_type(place, draw);
    Some(())
}

fn renamed(value: &mut Value, context: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let pointer = pointers::pick(value, draw)?;
    let (parent, key) = pointers::parts(&pointer);
    let to = match draw.below(3) {
        0 => format!("{key}_x"),
        1 => key.to_uppercase(),
        _ => {
            let other = context.corpus.any_value(context.kind, draw)?;
            let keys = pointers::keys(other);
            let key = keys.keys().nth(draw.below(keys.len()))?;
            key.clone()
        }
    };
    let Some(Value::Object(map)) = value.pointer_mut(parent) else { return None };
    pointers::rename(map, &key, to);
    Some(())
}

fn unknown_key(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let Some(Value::Object(map)) = somewhere(value, draw) else { return None };
    let inner = values::number(draw);
    let inner = if draw.chance(30) { json!({"deeper": [inner, null, "x"]}) } else { inner };
    map.insert(UNKNOWN.into(), inner);
    Some(())
}

fn word(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    *some(value, Value::is_string, draw)? = json!(values::word(draw));
    Some(())
}

fn spliced(value: &mut Value, context: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let other = context.corpus.any_value(context.kind, draw)?;
    let theirs = pointers::keys(other);
    let (key, places) = theirs.iter().nth(draw.below(theirs.len()))?;
    let part = other.pointer(draw.of(places).as_str()).cloned()?;
    let ours = pointers::keys(value);
    match ours.get(key) {
        Some(places) => *value.pointer_mut(draw.of(places).as_str())? = part,
        // A key of the top that is not here yet.
        None if other.get(key).is_some() => {
            let Value::Object(map) = value else { return None };
            map.insert(key.clone(), part);
        }
        None => return None,
    }
    Some(())
}

fn exchanged(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let (one, other) = (pointers::pick(value, draw), pointers::pick(value, draw));
    let (one, other) = one.zip(other)?;
    if one.starts_with(&other) || other.starts_with(&one) {
        return None;
    }
    let (a, b) = (value.pointer(&one).cloned()?, value.pointer(&other).cloned()?);
    for (place, part) in [(one, b), (other, a)] {
        value.pointer_mut(&place).into_iter().for_each(|place| *place = part.clone());
    }
    Some(())
}

fn twice(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let Some(Value::Array(list)) = some(value, Value::is_array, draw) else { return None };
    let item = list.get(draw.below(list.len()))?.clone();
    list.insert(draw.below(list.len() + 1), item);
    Some(())
}

fn list(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let Some(Value::Array(list)) = some(value, Value::is_array, draw) else { return None };
    match draw.below(4) {
        0 => list.clear(),
        1 => list.truncate(draw.below(list.len())),
        2 => draw.shuffle(list),
        _ => list.reverse(),
    }
    Some(())
}

fn nested(value: &mut Value, _: &Context<'_>, draw: &mut Draw) -> Option<()> {
    let place = somewhere(value, draw)?;
    *place = values::nested(place.take(), draw);
    Some(())
}
