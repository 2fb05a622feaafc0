//! Golden documents, a line a case. BLESS=1 writes them anew; read the difference before it is kept.

use common::{Document, to_text};
use scalarcal::Options;

fn case(name: &str, input: &str, options: Options) {
    testkit::golden(&format!("scalarcal/{name}"), input, |text| {
        let document = Document::parse(text).unwrap_or_else(|error| panic!("{name}: {error}"));
        to_text(&scalarcal::run(document, &options).unwrap_or_else(|error| panic!("{name}: {error}")))
    });
}

#[test]
fn golden() {
    case("meadow", "scalarcal/meadow/input.json", Options::default());
    case(
        "meadow-constant",
        "scalarcal/meadow-constant/input.json",
        Options { constant_magnitude: true, ..Options::default() },
    );
    case("three-orbits", "scalarcal/three-orbits/input.json", Options { vector: true, ..Options::default() });
}
