//! The committed schema of the mapping is the one that the type gives; the mappings of the fixtures are valid
//! by it, and the documents by theirs. BLESS=1 writes it anew.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

fn json(path: &Path) -> Value {
    let text = fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn committed_schema_and_fixtures() {
    let schema = schemars::schema_for!(ingest::Mapping);
    let schema = common::schema::titled(schema, "fluxcal mapping", "mapping.schema.json");
    let file = testkit::fixture("../schemas/mapping.schema.json");
    if testkit::bless() {
        fs::write(&file, common::to_text(&schema)).expect("written");
    }
    assert!(
        json(&file) == schema,
        "the types have changed: run with BLESS=1, read the difference, commit it"
    );

    let files = |folder: &str| {
        let entries = fs::read_dir(testkit::fixture(folder)).expect("a folder");
        entries.map(|entry| entry.expect("an entry").path()).collect::<Vec<PathBuf>>()
    };
    let valid = |validator: &jsonschema::Validator, path: &Path| {
        let value = json(path);
        let error = validator.iter_errors(&value).next().map(|error| error.to_string());
        assert!(error.is_none(), "{}: {error:?}", path.display());
        value
    };
    let mappings = jsonschema::validator_for(&schema).expect("a schema");
    let mut all = files("ingest/real");
    all.extend(["counts", "codes"].map(|name| testkit::fixture(&format!("ingest/{name}-map.json"))));
    assert!(all.len() > 10);
    for path in all {
        let mapping = ingest::Mapping::parse(&valid(&mappings, &path).to_string());
        mapping.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    assert!(!mappings.is_valid(&json(&testkit::fixture("bad/ingest/map-key-unknown.json"))));
    let documents = jsonschema::validator_for(&common::schema::document()).expect("a schema");
    let cases = files("ingest").into_iter().map(|path| path.join("expected.json"));
    cases.filter(|path| path.is_file()).for_each(|path| drop(valid(&documents, &path)));
}
