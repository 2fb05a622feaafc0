//! The committed schema is the one that the types give, and every document of the fixtures is valid by it.
//! BLESS=1 writes it anew.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Documents of a folder and of the folders below.
fn documents(folder: &Path, all: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> =
        fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            documents(&path, all);
        } else if path.extension().is_some_and(|end| end == "json")
            && path.file_name() != Some("tolerances.json".as_ref())
        {
            all.push(path);
        }
    }
}

#[test]
fn committed_schema_and_fixtures() {
    let schema = common::schema::document();
    let file = root().join("schemas/document.schema.json");
    if std::env::var_os("BLESS").is_some() {
        fs::write(&file, common::to_text(&schema)).expect("written");
    }
    let committed: Value =
        serde_json::from_str(&fs::read_to_string(&file).expect("committed")).expect("JSON");
    assert!(committed == schema, "the types have changed: run with BLESS=1, read the difference, commit it");

    let validator = jsonschema::validator_for(&schema).expect("a schema");
    let mut all = Vec::new();
    documents(&root().join("fixtures/nasa-1977"), &mut all);
    documents(&root().join("fixtures/axescal"), &mut all);
    documents(&root().join("fixtures/coilcal"), &mut all);
    documents(&root().join("fixtures/absolute"), &mut all);
    assert!(all.len() > 10);
    for path in all {
        let document: Value =
            serde_json::from_str(&fs::read_to_string(&path).expect("readable")).expect("JSON");
        let errors: Vec<String> = validator
            .iter_errors(&document)
            .map(|error| format!("{}: {error}", error.instance_path()))
            .collect();
        assert!(errors.is_empty(), "{}: {errors:?}", path.display());
        common::Document::parse(&document.to_string())
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
}

#[test]
fn the_schema_refuses_what_the_types_refuse() {
    let validator = jsonschema::validator_for(&common::schema::document()).expect("a schema");
    for name in ["nan-as-text", "no-format"] {
        let text = fs::read_to_string(root().join(format!("fixtures/bad/{name}.json"))).expect("readable");
        let document: Value = serde_json::from_str(&text).expect("JSON");
        assert!(!validator.is_valid(&document), "{name}");
    }
}
