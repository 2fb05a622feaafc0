//! Numbers from outside the project.

use serde_json::Value;

/// `fixtures/reference/NAME.json`.
pub fn reference(name: &str) -> Value {
    serde_json::from_str(&crate::read_fixture(&format!("reference/{name}.json"))).expect("JSON")
}

/// A list of it.
pub fn list(value: &Value) -> &[Value] {
    value.as_array().expect("a list")
}

/// A number of it.
pub fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// A list of numbers of it.
pub fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(number).collect()
}
