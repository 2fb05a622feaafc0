//! Golden documents, a line a case (BLESS=1 writes them anew: read the difference), faults, help.

use common::{Document, to_text};

use crate::build::{calibrated, simulated};

const COILCAL: &str = env!("CARGO_BIN_EXE_coilcal");

fn case(name: &str, input: &str) {
    testkit::golden(&format!("coilcal/{name}"), input, |text| {
        let document = Document::parse(text).unwrap_or_else(|error| panic!("{name}: {error}"));
        let found = coilcal::run(document, &coilcal::Options::default());
        to_text(&found.unwrap_or_else(|error| panic!("{name}: {error}")))
    });
}

#[test]
fn golden() {
    case("every-procedure", "simulate/every-procedure/expected.json");
    case("uneven", "coilcal/uneven/input.json");
}

#[test]
fn readings_in_files_beside_the_document() {
    testkit::beside(COILCAL, "coilcal/uneven/input.json");
}

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/coilcal", COILCAL) >= 9);
}

#[test]
fn examples_run_and_completions_and_man_pages_are_there() {
    testkit::examples(COILCAL, &[]);
    testkit::manual(COILCAL);
}

/// Their drives stay within the scalar magnetometer's range.
#[test]
fn campaigns_of_plans_are_read() {
    for name in ["cubesat", "magsat"] {
        let plan = testkit::read_fixture(&format!("plans/{name}.json"));
        let plan = serde_json::from_str(&plan).expect("JSON");
        let coils = calibrated(simulated(&plan)).coils.expect("coils");
        assert!(coils.z.is_some_and(|coil| coil.constant_nt_per_a.is_some()), "{name}");
    }
}
