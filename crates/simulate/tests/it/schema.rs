//! The committed schemas of plan and truth are the ones that the types give; every plan is valid by its own.
//! BLESS=1 writes them anew.

use serde_json::Value;
use std::fs;
use std::path::Path;

fn check(schema: Value, file: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../schemas").join(file);
    if testkit::bless() {
        fs::write(&path, common::to_text(&schema)).expect("written");
    }
    let committed: Value =
        serde_json::from_str(&fs::read_to_string(&path).expect("committed")).expect("JSON");
    assert!(committed == schema, "the types have changed: run with BLESS=1, read the difference, commit it");
    schema
}

#[test]
fn committed_schemas_and_plans() {
    let plan = schemars::schema_for!(simulate::Plan);
    let plan = check(common::schema::titled(plan, "fluxcal plan", "plan.schema.json"), "plan.schema.json");
    let truth = schemars::schema_for!(simulate::Truth);
    let truth =
        check(common::schema::titled(truth, "fluxcal truth", "truth.schema.json"), "truth.schema.json");
    let observatory = schemars::schema_for!(simulate::ObservatoryPlan);
    let observatory = common::schema::titled(observatory, "fluxcal observatory", "observatory.schema.json");
    let observatories =
        jsonschema::validator_for(&check(observatory, "observatory.schema.json")).expect("a schema");
    let flight = schemars::schema_for!(simulate::FlightPlan);
    let flight = common::schema::titled(flight, "fluxcal flight", "flight.schema.json");
    let flights = jsonschema::validator_for(&check(flight, "flight.schema.json")).expect("a schema");
    let plans = jsonschema::validator_for(&plan).expect("a schema");
    let truths = jsonschema::validator_for(&truth).expect("a schema");
    for entry in fs::read_dir(testkit::fixture("plans")).expect("fixtures/plans") {
        let path = entry.expect("an entry").path();
        let text = fs::read_to_string(&path).expect("readable");
        let value: Value = serde_json::from_str(&text).expect("JSON");
        if value.get("weeks").is_some() {
            assert!(observatories.is_valid(&value), "{}", path.display());
            continue;
        }
        if value.get("cameras").is_some() {
            assert!(flights.is_valid(&value), "{}", path.display());
            continue;
        }
        assert!(plans.is_valid(&value), "{}: {:?}", path.display(), plans.iter_errors(&value).next());
        let plan: simulate::Plan =
            simulate::Plan::parse(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let campaign =
            simulate::campaign(&plan).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert!(truths.is_valid(&serde_json::to_value(&campaign.truth).expect("JSON")));
    }
}
