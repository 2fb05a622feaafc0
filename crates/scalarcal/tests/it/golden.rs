//! Golden documents, a line a case. BLESS=1 writes them anew; read the difference before it is kept.

use common::{Document, to_text};
use scalarcal::{Columns, Options, stream};

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
    case(
        "meadow-windows",
        "scalarcal/meadow/input.json",
        Options { windows_s: Some(80.0), ..Options::default() },
    );
}

#[test]
fn pieces() {
    testkit::golden("scalarcal/pieces", "scalarcal/pieces/stated.json", |text| {
        let stated = Document::parse(text).expect("a document");
        let take = |name: &str| {
            partial::take(&Columns, &testkit::fixture(&format!("scalarcal/pieces/{name}.csv")))
                .expect("a piece")
        };
        let joined = partial::merge(vec![take("evening"), take("morning")]).expect("one series");
        to_text(&stream::document(&joined, stated, &Options::default()).expect("a calibration"))
    });
}
