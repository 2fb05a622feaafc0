//! The committed schemas of plan and truth are the ones that the types give; every plan is valid by its own.
//! BLESS=1 writes them anew.

use serde_json::Value;
use std::fs;
use std::path::Path;

/// The committed schema of a type, which is the one that it gives, as a validator.
fn committed(schema: schemars::Schema, kind: &str) -> jsonschema::Validator {
    let file = format!("{kind}.schema.json");
    let schema = common::schema::titled(schema, &format!("fluxcal {kind}"), &file);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../schemas").join(file);
    if testkit::bless() {
        fs::write(&path, common::to_text(&schema)).expect("written");
    }
    let committed: Value =
        serde_json::from_str(&fs::read_to_string(&path).expect("committed")).expect("JSON");
    assert!(committed == schema, "the types have changed: run with BLESS=1, read the difference, commit it");
    jsonschema::validator_for(&schema).expect("a schema")
}

#[test]
fn committed_schemas_and_plans() {
    let plans = committed(schemars::schema_for!(simulate::Plan), "plan");
    let truths = committed(schemars::schema_for!(simulate::Truth), "truth");
    let observatories = committed(schemars::schema_for!(simulate::ObservatoryPlan), "observatory");
    let flights = committed(schemars::schema_for!(simulate::FlightPlan), "flight");
    for entry in fs::read_dir(testkit::fixture("plans")).expect("fixtures/plans") {
        let path = entry.expect("an entry").path();
        let text = fs::read_to_string(&path).expect("readable");
        let value: Value = serde_json::from_str(&text).expect("JSON");
        let schema = match value.get("weeks").is_some() {
            true => &observatories,
            false if value.get("cameras").is_some() => &flights,
            false => &plans,
        };
        assert!(schema.is_valid(&value), "{}: {:?}", path.display(), schema.iter_errors(&value).next());
        if std::ptr::eq(schema, &plans) {
            let made = simulate::Plan::parse(&text).and_then(|plan| simulate::campaign(&plan));
            let made = made.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            assert!(truths.is_valid(&serde_json::to_value(&made.truth).expect("JSON")));
        }
    }
}
