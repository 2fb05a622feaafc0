//! Golden documents, a line a case. BLESS=1 writes them anew; read the difference before it is kept.

use common::{Document, to_text};

fn case(name: &str, input: &str) {
    testkit::golden(&format!("sensorcal/{name}"), input, |text| {
        let document = Document::parse(text).unwrap_or_else(|error| panic!("{name}: {error}"));
        let found = sensorcal::run(document, &sensorcal::Options::default());
        to_text(&found.unwrap_or_else(|error| panic!("{name}: {error}")))
    });
}

#[test]
fn golden() {
    case("small", "sensorcal/small/input.json");
}

#[test]
fn readings_in_files_beside_the_document() {
    testkit::beside(env!("CARGO_BIN_EXE_sensorcal"), "sensorcal/small/input.json");
}
