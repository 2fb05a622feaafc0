//! JSON Schemas of the formats, generated from the types.

use serde_json::Value;

use crate::Document;

/// Schema of the document, JSON Schema draft 2020-12.
pub fn document() -> Value {
    let mut schema = titled(schemars::schema_for!(Document), "fluxcal document", "document.schema.json");
    let mut results: Vec<String> = Vec::new();
    for part in ["calibration", "model", "diagnosis"] {
        referred(&schema["properties"][part], &schema["$defs"], &mut results);
    }
    results.iter().for_each(|name| undetermined(&mut schema["$defs"][name]));
    schema
}

/// The definitions that a schema rests on.
fn referred(schema: &Value, definitions: &Value, found: &mut Vec<String>) {
    let own = schema.get("$ref").and_then(|path| path.as_str()?.strip_prefix("#/$defs/"));
    if let Some(name) = own.filter(|name| !found.iter().any(|other| other == name)) {
        found.push(name.into());
        referred(&definitions[name], definitions, found);
    }
    parts(schema).for_each(|part| referred(part, definitions, found));
}

/// A number of a result may be `null`.
fn undetermined(schema: &mut Value) {
    if schema.get("type").is_some_and(|kind| kind == "number") {
        schema["type"] = serde_json::json!(["number", "null"]);
    }
    match schema {
        Value::Array(items) => items.iter_mut().for_each(undetermined),
        Value::Object(entries) => entries.values_mut().for_each(undetermined),
        _ => {}
    }
}

/// What stands within a value.
fn parts(value: &Value) -> Box<dyn Iterator<Item = &Value> + '_> {
    match value {
        Value::Array(items) => Box::new(items.iter()),
        Value::Object(entries) => Box::new(entries.values()),
        _ => Box::new(std::iter::empty()),
    }
}

/// A generated schema with its title and file name.
pub fn titled(schema: schemars::Schema, title: &str, id: &str) -> Value {
    let mut value = schema.to_value();
    value["title"] = title.into();
    value["$id"] = id.into();
    value
}
