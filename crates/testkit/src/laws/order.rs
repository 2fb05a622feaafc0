//! How recordings are listed, and where one ends.

use serde_json::Value;

use super::draw::Draw;
use super::walk::recordings;

/// The recordings in another order, drawn from a seed.
pub fn reorder(document: &Value, seed: u64) -> Value {
    let mut reordered = document.clone();
    let mut draw = Draw::new(seed);
    let list = reordered["recordings"].as_array_mut().expect("recordings");
    for last in (1..list.len()).rev() {
        list.swap(last, draw.below(last + 1));
    }
    reordered
}

/// Each recording of a procedure as two, the second from a row on that is a multiple of `rows` and drawn from
/// a seed: the times still count from the same beginning.
pub fn split(document: &Value, procedure: &str, rows: usize, seed: u64) -> Value {
    let mut apart = document.clone();
    let mut draw = Draw::new(seed);
    let mut second = Vec::new();
    for recording in recordings(&mut apart).filter(|recording| recording["procedure"] == procedure) {
        let columns = recording["columns"].as_object().expect("columns");
        let all = columns.values().next().and_then(Value::as_array).map_or(0, Vec::len) / rows;
        if all < 2 {
            continue;
        }
        let at = rows * (1 + draw.below(all - 1));
        let mut rest = recording.clone();
        rest["id"] = format!("{}-rest", recording["id"].as_str().expect("an id")).into();
        for column in recording["columns"].as_object_mut().expect("columns").values_mut() {
            column.as_array_mut().expect("a column").truncate(at);
        }
        for column in rest["columns"].as_object_mut().expect("columns").values_mut() {
            column.as_array_mut().expect("a column").drain(..at);
        }
        second.push(Value::Object(rest));
    }
    assert!(!second.is_empty(), "no recording of {procedure} to be split");
    apart["recordings"].as_array_mut().expect("recordings").extend(second);
    apart
}
