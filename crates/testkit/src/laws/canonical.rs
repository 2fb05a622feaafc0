//! One form for answers that differ only in the order of what has none.

use common::covariance::rows;
use faer::Mat;
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

use super::walk::{covariance, matrix};

/// A document with lists whose order means nothing sorted: recordings, covariances by their names, what is
/// listed for each of several recordings, sensors or effects. Numbers of recordings and orientations become
/// their ids. What a recording holds stays.
pub fn canonical(document: &Value) -> Value {
    of(document, &Names::default())
}

/// What numbers in a list stand for.
#[derive(Clone, Default)]
struct Names {
    recordings: Vec<Value>,
    orientations: Vec<Value>,
}

fn of(value: &Value, names: &Names) -> Value {
    match value {
        Value::Object(object) => of_object(object, names),
        Value::Array(list) => {
            let mut list: Vec<Value> = list.iter().map(|item| of(item, names)).collect();
            if list.iter().all(|item| item.is_object() || item.is_string()) {
                list.sort_by_key(name_of);
            }
            Value::Array(list)
        }
        other => other.clone(),
    }
}

fn of_object(object: &Map<String, Value>, names: &Names) -> Value {
    let mut names = names.clone();
    if let Some(list) = strings(object.get("recordings")) {
        names.recordings = list;
    }
    if let Some(list) = object.get("orientations").and_then(Value::as_array) {
        names.orientations = list.iter().map(|one| of(&one["recordings"], &names)).collect();
    }
    let mut sorted = by_name(object);
    let table = is_table(object);
    for (key, value) in &mut sorted {
        match key.as_str() {
            "columns" | "covariance" | "covariance_order" => {}
            "uncertainty" if value.get("sources").is_some() => *value = covariance_of_sources(value),
            "recording" => *value = named(value, &names.recordings, 0),
            "orientation" => *value = named(value, &names.orientations, 1),
            _ if table => {}
            _ => *value = of(value, &names),
        }
    }
    if table {
        rows_by_name(&mut sorted);
    }
    Value::Object(sorted)
}

/// The covariance that sources make: of one covariance there are many roots. What is in GEO is left to the
/// covariances that stand beside the values.
fn covariance_of_sources(value: &Value) -> Value {
    let of = |source: &Value| source["moves"].as_object().cloned().unwrap_or_default();
    let sources: Vec<Map<String, Value>> =
        value["sources"].as_array().into_iter().flatten().map(of).collect();
    let in_geo = |path: &&String| path.contains("axes.coils.") || path.contains("residual_field");
    let paths: BTreeSet<&String> =
        sources.iter().flat_map(|moves| moves.keys()).filter(|path| !in_geo(path)).collect();
    let moved =
        |moves: &Map<String, Value>, path: &String| moves.get(path).and_then(Value::as_f64).unwrap_or(0.0);
    let entry =
        |a: &String, b: &String| sources.iter().map(|moves| moved(moves, a) * moved(moves, b)).sum::<f64>();
    let rows: Vec<Vec<f64>> = paths.iter().map(|a| paths.iter().map(|b| entry(a, b)).collect()).collect();
    json!({"covariance": rows, "covariance_order": paths})
}

/// Whole numbers from `first` on as what they stand for.
fn named(value: &Value, names: &[Value], first: u64) -> Value {
    let name = |number: &Value| match number.as_u64().and_then(|number| number.checked_sub(first)) {
        Some(place) => names.get(place as usize).unwrap_or(number).clone(),
        None => number.clone(),
    };
    match value {
        Value::Array(list) => list.iter().map(name).collect(),
        other => name(other),
    }
}

fn strings(value: Option<&Value>) -> Option<Vec<Value>> {
    let list = value?.as_array()?;
    list.iter().all(Value::is_string).then(|| list.clone())
}

/// What an item of a list is known by: its words and names.
fn name_of(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(list) => list.iter().map(name_of).collect::<Vec<_>>().join(" "),
        Value::Object(object) => {
            let is_name = |value: &&Value| value.is_string() || strings(Some(value)).is_some();
            object.values().filter(is_name).map(name_of).collect::<Vec<_>>().join(" ")
        }
        _ => String::new(),
    }
}

/// Where each name of a sorted list stood.
fn places(names: &[String]) -> Vec<usize> {
    let mut places: Vec<usize> = (0..names.len()).collect();
    places.sort_by(|a, b| names[*a].cmp(&names[*b]));
    places
}

/// Covariances by the names that they run over.
fn by_name(object: &Map<String, Value>) -> Map<String, Value> {
    let mut sorted = object.clone();
    let order = |part: &str| Some(places(&covariance(object.get(part)?.as_object()?)?.1));
    if let Some((covariance, names)) = covariance(object) {
        let places = places(&names);
        let names: Vec<&String> = places.iter().map(|place| &names[*place]).collect();
        sorted.insert("covariance_order".into(), json!(names));
        sorted.insert("covariance".into(), permuted(&covariance, &places, &places));
    }
    if let Some(cross) = object.get("cross_covariance").and_then(matrix)
        && let (Some(rows), Some(columns)) = (order("sensors"), order("coils"))
    {
        sorted.insert("cross_covariance".into(), permuted(&cross, &rows, &columns));
    }
    sorted
}

fn permuted(matrix: &Mat<f64>, places: &[usize], across: &[usize]) -> Value {
    json!(rows(&Mat::from_fn(places.len(), across.len(), |i, j| matrix[(places[i], across[j])])))
}

/// Whether an object is lists of one length that stand side by side.
fn is_table(object: &Map<String, Value>) -> bool {
    let rows = |value: &Value| value.as_array().map(Vec::len);
    let first = object.values().next().and_then(rows);
    object.len() > 1 && first.is_some() && object.values().all(|value| rows(value) == first)
}

/// The rows of a table that names what they are of, sorted by the recording, the row and all other names.
fn rows_by_name(object: &mut Map<String, Value>) {
    let lists: Vec<&Vec<Value>> = object.values().filter_map(Value::as_array).collect();
    let rows = lists.first().map_or(0, |list| list.len());
    let is_name = |list: &&Vec<Value>| list.iter().all(|item| item.is_string() || item.is_array());
    let named: Vec<&Vec<Value>> = lists.into_iter().filter(is_name).collect();
    if named.is_empty() {
        return;
    }
    let name = |key: &str, row: usize| object.get(key).map(|list| name_of(&list[row]));
    let number = |row: usize| object.get("row").and_then(|list| list[row].as_u64());
    let names = |row: usize| named.iter().map(|list| name_of(&list[row])).collect::<Vec<_>>();
    let mut order: Vec<usize> = (0..rows).collect();
    order
        .sort_by_cached_key(|row| (name("recording", *row), number(*row), name("sensor", *row), names(*row)));
    for list in object.values_mut().filter_map(Value::as_array_mut) {
        *list = order.iter().map(|row| list[*row].clone()).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_recordings_is_gone_and_that_of_times_is_not() {
        let one = json!({"recordings": ["b", "a"], "levels": {"recording": [0, 0, 1], "field_nt": [1.0, 2.0, 3.0]},
            "covariance": [[1.0, 2.0], [2.0, 4.0]], "covariance_order": ["k", "a"], "spectrum": {"f": [3.0, 1.0], "p": [1.0, 2.0]}});
        let other = json!({"recordings": ["a", "b"], "levels": {"recording": [0, 1, 1], "field_nt": [3.0, 1.0, 2.0]},
            "covariance": [[4.0, 2.0], [2.0, 1.0]], "covariance_order": ["a", "k"], "spectrum": {"f": [3.0, 1.0], "p": [1.0, 2.0]}});
        assert_eq!(canonical(&one), canonical(&other));
        let recorded = json!({"columns": {"time_s": [2.0, 1.0], "mode": ["b", "a"]}});
        assert_eq!(canonical(&recorded), recorded);
    }
}
