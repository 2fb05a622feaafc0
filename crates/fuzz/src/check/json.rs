//! JSON that a program wrote, against its published schema.

use jsonschema::Validator;
use serde_json::Value;
use std::fs;
use std::path::Path;

use crate::Error;
use crate::commands::Writes;
use crate::finding::{Fault, Rule};
use crate::mutate::json::UNKNOWN;
use crate::mutate::pointers;

/// Keys below which null says that something is missing or was not looked for, or is what was read.
const MAY_BE_NULL: [&str; 6] = ["columns", "clock", "readings", "fields_nt", "reference_c", UNKNOWN];

pub struct Schemas {
    document: Validator,
    mapping: Validator,
    truth: Validator,
}

impl Schemas {
    /// From the folder where they are published.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        let of = |name: &str| {
            let path = folder.join(format!("{name}.schema.json"));
            let text = fs::read(&path).map_err(|e| Error::file(&path, "read", e))?;
            let schema: Value = serde_json::from_slice(&text)
                .map_err(|e| Error::Request(format!("{}: no JSON ({e})", path.display())))?;
            jsonschema::validator_for(&schema)
                .map_err(|e| Error::Request(format!("{}: no schema ({e})", path.display())))
        };
        Ok(Self { document: of("document")?, mapping: of("mapping")?, truth: of("truth")? })
    }

    /// Faults of what was written, where this was read.
    pub fn faults(&self, writes: Writes, written: &[u8], read: &[u8]) -> Vec<Fault> {
        let read = serde_json::from_slice(read).unwrap_or_default();
        let schema = match writes {
            Writes::Document => Some(&self.document),
            Writes::Mapping => Some(&self.mapping),
            Writes::Documents => {
                let lines = written.split(|byte| *byte == b'\n').filter(|line| !line.is_empty());
                return lines.flat_map(|line| one(line, &read, Some(&self.document))).collect();
            }
            Writes::Piece | Writes::Json | Writes::Text => None,
        };
        one(written, &read, schema)
    }

    pub fn of_truth(&self, written: &[u8]) -> Vec<Fault> {
        one(written, &Value::Null, Some(&self.truth))
    }
}

fn one(written: &[u8], read: &Value, schema: Option<&Validator>) -> Vec<Fault> {
    let value: Value = match serde_json::from_slice(written) {
        Ok(value) => value,
        Err(error) => return vec![Fault::new(Rule::Schema, format!("no JSON: {error}"))],
    };
    let mut faults = Vec::new();
    let mut others = value.clone();
    for place in undetermined(&value) {
        others.pointer_mut(&place).into_iter().for_each(|listed| *listed = true.into());
    }
    if let Some(place) = null(&others, read, "") {
        faults.push(Fault::new(Rule::NotANumber, format!("null at {place}")));
    }
    if let Some(error) = schema.and_then(|schema| schema.iter_errors(&value).next()) {
        let text: String = error.to_string().chars().take(200).collect();
        faults.push(Fault::new(Rule::Schema, format!("{}: {text}", error.instance_path())));
    }
    faults
}

/// Where `undetermined` of a document says that there may be null.
fn undetermined(document: &Value) -> Vec<String> {
    let listed = document.get("undetermined").and_then(Value::as_array).into_iter().flatten();
    let pointer = |path: &str| format!("/{}", path.replace(']', "").replace(['.', '['], "/"));
    listed.filter_map(|one| Some(pointer(one.get("path")?.as_str()?))).collect()
}

/// The first null that was not read in the same place and says nothing.
fn null(value: &Value, read: &Value, pointer: &str) -> Option<String> {
    match value {
        Value::Null if read.pointer(pointer).is_none_or(|read| !read.is_null()) => Some(pointer.into()),
        Value::Object(map) => {
            let mut others = map.iter().filter(|(key, _)| !MAY_BE_NULL.contains(&key.as_str()));
            others.find_map(|(key, child)| null(child, read, &pointers::below(pointer, key)))
        }
        Value::Array(list) => {
            let mut items = list.iter().enumerate();
            items.find_map(|(index, child)| null(child, read, &format!("{pointer}/{index}")))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nulls_and_schemas() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../schemas");
        let schemas = Schemas::read(&root).expect("schemas");
        let rules = |written: &str, read: &str| -> Vec<Rule> {
            let faults = schemas.faults(Writes::Document, written.as_bytes(), read.as_bytes());
            faults.into_iter().map(|fault| fault.rule).collect()
        };
        assert_eq!(rules(r#"{"fluxcal": 1, "own": null}"#, r#"{"own": null}"#), []);
        assert_eq!(rules(r#"{"fluxcal": 1, "own": null}"#, "{}"), [Rule::NotANumber]);
        let listed = r#"{"fluxcal": 1, "calibration": {"coils": {"x": {"offset_nt": {"value": 1, "std": null}}}},
            "undetermined": [{"path": "calibration.coils.x.offset_nt.std", "reason": "few readings"}]}"#;
        assert_eq!(rules(listed, "{}"), []);
        assert_eq!(rules(r#"{"fluxcal": "1"}"#, ""), [Rule::Schema]);
        assert_eq!(rules("{", ""), [Rule::Schema]);
        let missing =
            r#"{"fluxcal": 1, "recordings": [{"id": "a", "procedure": "b", "columns": {"time_s": [null]}}]}"#;
        assert_eq!(rules(missing, ""), []);
    }
}
