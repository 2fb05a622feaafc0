//! Golden documents, a line a case (BLESS=1 writes them anew; read the difference before it is kept), faults
//! with their messages, and the program's help.

use absolute::run;
use common::{AbsoluteCalibration, Document, to_text};

const ABSOLUTE: &str = env!("CARGO_BIN_EXE_absolute");

fn done(name: &str, text: &str) -> Document {
    let document = Document::parse(text).unwrap_or_else(|error| panic!("{name}: {error}"));
    run(document).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn case(name: &str) -> AbsoluteCalibration {
    let (case, input) = (format!("absolute/{name}"), format!("absolute/{name}/input.json"));
    testkit::golden(&case, &input, |text| to_text(&done(name, text)));
    let document = done(name, &testkit::read_fixture(&input));
    *document.calibration.expect("a calibration").absolute.expect("measurements")
}

#[test]
fn golden() {
    assert_eq!(case("weeks").sets.len(), 16);
    assert_eq!(case("null-method").components.as_deref(), Some("xyz"));
}

#[test]
fn a_misread_circle_is_named_by_row_and_position() {
    let found = case("misread");
    let words: Vec<String> =
        found.sets.iter().flat_map(|set| set.findings.iter()).map(ToString::to_string).collect();
    assert_eq!(words.len(), 1, "{words:?}");
    assert!(words[0].starts_with("row 4 (west up) is off by "), "{words:?}");
}

#[test]
fn a_step_is_where_it_is() {
    let adopted = case("step").adopted.expect("baselines");
    // Day 42 is between the measurements of the sixth week and of the seventh. That of D is found because the others
    // step there.
    for (key, component) in &adopted.components {
        let steps = component.steps.iter().map(|step| (step.after.as_str(), step.before.as_str()));
        assert_eq!(steps.collect::<Vec<_>>(), [("week-006-1", "week-007-1")], "{key}");
    }
}

/// The sensor along x reads 0.8 nT more in each kelvin: its baseline falls.
#[test]
fn a_temperature_is_followed() {
    let adopted = case("warm").adopted.expect("baselines");
    let [one] = &adopted.components["h_nt"].follows[..] else { panic!("one column") };
    let std = one.coefficient.std().expect("a standard uncertainty");
    assert_eq!(one.column, "sensor_temperature_c");
    assert!((one.coefficient.value() + 0.8).abs() < 3.0 * std && std < 0.1, "{:?}", one.coefficient);
}

#[test]
fn readings_in_files_beside_the_document() {
    testkit::beside(ABSOLUTE, "absolute/weeks/input.json");
}

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad/absolute", ABSOLUTE) >= 28);
}

#[test]
fn examples_run_and_completions_and_man_pages_are_there() {
    testkit::examples(ABSOLUTE, &[]);
    testkit::manual(ABSOLUTE);
}
