//! Ways through JSON that the changes share.

use faer::Mat;
use serde_json::{Map, Value};

/// Whether a text is for people: names, ids and choices have no space.
pub fn is_prose(text: &str) -> bool {
    text.contains(' ')
}

/// Whether a path ends in one of these, or goes through it.
pub fn is_apart(path: &str, apart: &[&str]) -> bool {
    apart.iter().any(|apart| format!("{path}.").contains(&format!(".{apart}.")))
}

/// Every number below, changed.
pub fn numbers(value: &mut Value, change: &dyn Fn(f64) -> f64) {
    match value {
        Value::Number(number) => *value = change(number.as_f64().expect("a number")).into(),
        Value::Array(list) => list.iter_mut().for_each(|item| numbers(item, change)),
        Value::Object(object) => object.values_mut().for_each(|item| numbers(item, change)),
        _ => {}
    }
}

/// Every object below with its key, that of the list it stands in, the inner ones first.
pub fn objects(value: &mut Value, key: &str, change: &mut dyn FnMut(&str, &mut Map<String, Value>)) {
    match value {
        Value::Array(list) => list.iter_mut().for_each(|item| objects(item, key, change)),
        Value::Object(object) => {
            object.iter_mut().for_each(|(key, item)| objects(item, key, change));
            change(key, object);
        }
        _ => {}
    }
}

/// A matrix of numbers.
pub fn matrix(value: &Value) -> Option<Mat<f64>> {
    let row = |row: &Value| row.as_array()?.iter().map(Value::as_f64).collect::<Option<Vec<f64>>>();
    Some(common::covariance::matrix(&value.as_array()?.iter().map(row).collect::<Option<Vec<_>>>()?))
}

/// A covariance and the names that it runs over, where an object has both.
pub fn covariance(object: &Map<String, Value>) -> Option<(Mat<f64>, Vec<String>)> {
    let names = object.get("covariance_order")?.as_array()?.iter();
    let names: Vec<String> = names.filter_map(|name| Some(name.as_str()?.to_string())).collect();
    let covariance = matrix(object.get("covariance")?)?;
    (covariance.nrows() == names.len()).then_some((covariance, names))
}

/// The value of a quantity, whether it has a standard uncertainty or not.
pub fn quantity(value: &mut Value) -> Option<&mut Value> {
    if value.is_number() { Some(value) } else { value.as_object_mut()?.get_mut("value") }
}

/// The recordings of a document.
pub fn recordings(document: &mut Value) -> impl Iterator<Item = &mut Map<String, Value>> {
    document["recordings"].as_array_mut().into_iter().flatten().filter_map(Value::as_object_mut)
}
