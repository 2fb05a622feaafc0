//! JSON Schemas of the formats, generated from the types.

use serde_json::Value;

use crate::Document;

/// Schema of the document, JSON Schema draft 2020-12.
pub fn document() -> Value {
    titled(schemars::schema_for!(Document), "fluxcal document", "document.schema.json")
}

/// A generated schema with its title and file name.
pub fn titled(schema: schemars::Schema, title: &str, id: &str) -> Value {
    let mut value = schema.to_value();
    value["title"] = title.into();
    value["$id"] = id.into();
    value
}
