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

    let mappings = jsonschema::validator_for(&schema).expect("a schema");
    let documents = jsonschema::validator_for(&common::schema::document()).expect("a schema");
    let mut files: Vec<PathBuf> =
        vec![testkit::fixture("ingest/counts-map.json"), testkit::fixture("ingest/codes-map.json")];
    let real = fs::read_dir(testkit::fixture("ingest/real")).expect("mappings");
    files.extend(real.map(|entry| entry.expect("an entry").path()));
    assert!(files.len() > 10);
    for path in files {
        let mapping = json(&path);
        assert!(
            mappings.is_valid(&mapping),
            "{}: {:?}",
            path.display(),
            mappings.iter_errors(&mapping).next()
        );
        ingest::Mapping::parse(&mapping.to_string())
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    let bad = json(&testkit::fixture("bad/ingest/map-key-unknown.json"));
    assert!(!mappings.is_valid(&bad));
    for entry in fs::read_dir(testkit::fixture("ingest")).expect("cases") {
        let path = entry.expect("an entry").path().join("expected.json");
        if path.is_file() {
            let document = json(&path);
            assert!(
                documents.is_valid(&document),
                "{}: {:?}",
                path.display(),
                documents.iter_errors(&document).next()
            );
        }
    }
}
