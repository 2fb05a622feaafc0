//! Golden documents, a line a case (BLESS=1 writes them anew: read the difference), faults, help.

use axescal::{Options, Start};
use common::{Axis, Document, to_text};

const AXESCAL: &str = env!("CARGO_BIN_EXE_axescal");

fn case(name: &str, input: &str, options: Options) {
    testkit::golden(&format!("axescal/{name}"), input, |text| {
        let document = Document::parse(text).unwrap_or_else(|error| panic!("{name}: {error}"));
        to_text(&axescal::run(document, &options).unwrap_or_else(|error| panic!("{name}: {error}")))
    });
}

#[test]
fn golden() {
    let plain = Options::default;
    case("table-4", "nasa-1977/table-4.json", plain());
    case("table-4-robust", "nasa-1977/table-4.json", Options { robust: true, ..plain() });
    case("table-4-free-scales", "nasa-1977/table-4.json", Options { free_scales: true, ..plain() });
    case("table-4-without-29", "nasa-1977/table-4-without-29.json", plain());
    case("table-4-1-2-4", "nasa-1977/table-4-1-2-4.json", plain());
    case("table-1", "nasa-1977/table-1.json", plain());
    case("one-sensor", "nasa-1977/table-4.json", Options { sensor: Some(Axis::Y), ..plain() });
    case("magsat", "axescal/magsat/input.json", plain());
    case(
        "magsat-known-coils",
        "axescal/magsat-known-coils/input.json",
        Options { known_coils: true, ..plain() },
    );
    case("magsat-again", "axescal/magsat/expected.json", Options { start: Start::Document, ..plain() });
}

#[test]
fn readings_in_files_beside_the_document() {
    testkit::beside(AXESCAL, "axescal/magsat/input.json");
}

#[test]
fn each_fault_has_its_message() {
    assert!(testkit::faults("bad", AXESCAL) >= 20);
}

#[test]
fn examples_run_and_completions_and_man_pages_are_there() {
    testkit::examples(AXESCAL, &[]);
    testkit::manual(AXESCAL);
}
