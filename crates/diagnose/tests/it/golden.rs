//! Golden documents, a line a case. BLESS=1 writes them anew; read the difference before it is kept.

use common::{Document, to_text};
use diagnose::Options;

fn case(name: &str, input: &str, options: &Options) {
    testkit::golden(&format!("diagnose/{name}"), input, |text| {
        let document = Document::parse(text).unwrap_or_else(|error| panic!("{name}: {error}"));
        to_text(&diagnose::run(document, options).unwrap_or_else(|error| panic!("{name}: {error}")))
    });
}

#[test]
fn golden() {
    let plain = Options::default;
    case("warm", "diagnose/warm/input.json", &plain());
    case("delay", "diagnose/delay/input.json", &plain());
    case("orbit", "diagnose/orbit/input.json", &plain());
    case("warm-again", "diagnose/warm/expected.json", &plain());
}

#[test]
fn readings_in_files_beside_the_document() {
    testkit::beside(env!("CARGO_BIN_EXE_diagnose"), "diagnose/warm/input.json");
}
