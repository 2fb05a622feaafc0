//! A golden document (BLESS=1 writes it anew; read the difference before it is kept), faults with their messages, streams
//! and the program's help.

use common::{Document, FlightCalibration, to_text};
use starcal::{Columns, run};

const STARCAL: &str = env!("CARGO_BIN_EXE_starcal");

fn calibrated(document: Document) -> Document {
    run(document, &Columns::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn done(text: &str) -> Document {
    calibrated(Document::parse(text).expect("a document"))
}

fn flight(document: &Document) -> &FlightCalibration {
    document.calibration.as_ref().and_then(|found| found.flight.as_deref()).expect("a flight")
}

/// Two days with a current of which an ampere adds 4, −6 and 3 nT.
#[test]
fn golden() {
    let input = "starcal/day/input.json";
    testkit::golden("starcal/day", input, |text| to_text(&done(text)));
    let document = done(&testkit::read_fixture(input));
    let [term] = &flight(&document).terms[..] else { panic!("one term") };
    let known = (term.effect.as_deref(), term.column.as_deref());
    assert_eq!(known, (Some("stray_current"), Some("panel_current_a")));
    for (found, truth) in term.parameters.values().zip([4.0, -6.0, 3.0]) {
        assert!((found.value() - truth).abs() < 3.0 * found.std().expect("an uncertainty"), "{found}");
    }
    assert_eq!(document.model.expect("a model").effects[0].effect, "stray_current");
}

/// Late readings are told, with the time to a tenth: in a day the errors of the model are in it, and a long delay comes out
/// short where the spacecraft slews, as it is found to first order.
#[test]
fn late_readings_are_told() {
    for readings_s in [0.5, 10.0] {
        let latency = simulate::LatencyPlan { readings_s, ..simulate::LatencyPlan::default() };
        let plan = simulate::FlightPlan { step_s: 10.0, latency, ..simulate::FlightPlan::default() };
        let document = calibrated(simulate::flight(&plan).expect("a flight").document);
        let found = flight(&document);
        let told = |finding: &&String| finding.contains("late against field and attitude");
        assert!(found.findings.iter().any(|finding| told(&finding)), "{:?}", found.findings);
        let late =
            found.terms.iter().find_map(|term| term.parameters.get("readings_late_s")).expect("a time");
        assert!((late.value() / readings_s - 1.0).abs() < 0.1, "{late} {readings_s}");
    }
}

/// A second camera whose quaternions are of the inverse rotation, or that never sees stars, is left out with a finding.
#[test]
fn a_camera_that_does_not_follow_is_left_out() {
    let cameras = vec![simulate::CameraPlan::default(), simulate::CameraPlan::default()];
    let plan = simulate::FlightPlan { cameras, step_s: 120.0, ..simulate::FlightPlan::default() };
    let made = simulate::flight(&plan).expect("a flight").document;
    let changed = |of: fn(f64) -> f64, said: &str| {
        let mut document = made.clone();
        for part in ["x", "y", "z"] {
            let column =
                document.recordings[0].columns.get_mut(&format!("camera_2_{part}")).expect("a camera");
            *column = column.iter().map(|value| of(*value)).collect::<Vec<f64>>().into();
        }
        let document = calibrated(document);
        let found = flight(&document);
        assert_eq!(found.cameras.len(), 1);
        let told = |one: &&String| one.contains("camera_2 is left out") && one.contains(said);
        assert!(found.findings.iter().any(|one| told(&one)), "{:?}", found.findings);
    };
    changed(|value| -value, "not those of the first camera with one turn");
    changed(|_| f64::NAN, "no attitude at a time");
    assert_eq!(flight(&calibrated(made.clone())).cameras.len(), 2);
}

/// GPS time in place of UTC.
#[test]
fn times_of_gps_are_told() {
    let plan = simulate::FlightPlan { days: 2.0, step_s: 60.0, ..simulate::FlightPlan::default() };
    let mut made = simulate::flight(&plan).expect("a flight").document;
    made.recordings[0].start = Some("2025-03-01T00:00:18Z".into());
    let document = calibrated(made);
    let findings = &flight(&document).findings;
    assert!(findings.iter().any(|finding| finding.contains("they seem to be GPS time")), "{findings:?}");
}

#[test]
fn readings_in_files_beside_the_document() {
    testkit::beside(STARCAL, "starcal/day/input.json");
}

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/starcal", STARCAL) >= 17);
}

#[test]
fn examples_run_and_completions_and_man_pages_are_there() {
    testkit::examples(STARCAL, &["stream", "merge"]);
    testkit::manual(STARCAL);
}
