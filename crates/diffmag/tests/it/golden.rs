//! Golden documents, a line a case. BLESS=1 writes them anew; read the difference before it is kept. Each
//! holds the true answer under `truth`, made outside this project, and the answer is held against it as well.

use common::{Document, to_text};
use diffmag::Columns;
use serde_json::Value;
use testkit::reference::number;

use crate::answers::elements;

const INPUT: &str = "diffmag/turned-pair/input.json";

fn parse(text: &str) -> Document {
    Document::parse(text).expect("a document")
}

fn answer(document: Document) -> Document {
    diffmag::run(document, &diffmag::Options::default()).expect("fitted")
}

/// The same recording with the five of the test instrument stated in place of the reference's.
fn other_known(mut document: Document) -> Document {
    let stated = truth(&document)["known_of_the_test_instrument"].clone();
    let known = document.calibration.as_mut().and_then(|c| c.differential.as_mut()?.known.as_mut());
    *known.expect("what is known") = serde_json::from_value(stated).expect("what is known");
    document
}

fn in_pieces() -> Document {
    let piece = |name: &str| {
        partial::take(&Columns::default(), &testkit::fixture(&format!("diffmag/pieces/{name}.csv")))
    };
    let pieces = ["evening", "morning"].map(|name| piece(name).expect("a piece"));
    diffmag::stream::document(&partial::merge(pieces.into()).expect("one series")).expect("an answer")
}

#[test]
fn golden() {
    testkit::golden("diffmag/turned-pair", INPUT, |text| to_text(&answer(parse(text))));
    testkit::golden("diffmag/turned-pair-test-known", INPUT, |text| {
        to_text(&answer(other_known(parse(text))))
    });
    testkit::golden("diffmag/pieces", INPUT, |_| to_text(&in_pieces()));
}

fn truth(document: &Document) -> Value {
    document.extra.get("truth").expect("the truth").clone()
}

#[test]
fn the_truth_is_found() {
    let truth = truth(&parse(&testkit::read_fixture(INPUT)));
    let mut worst: (f64, String) = (0.0, String::new());
    let mut count = 0;
    let mut hold = |name: String, off: f64, std: f64| {
        count += 1;
        println!("{name}: {:+.2} standard uncertainties", off / std);
        if off.abs() / std > worst.0 {
            worst = (off.abs() / std, name);
        }
    };
    for case in ["turned-pair", "turned-pair-test-known", "pieces"] {
        let expected = parse(&testkit::read_fixture(&format!("diffmag/{case}/expected.json")));
        let found = expected.calibration.and_then(|calibration| calibration.differential).expect("an answer");
        let (matrix, covariance) =
            (found.matrix.expect("a matrix"), found.covariance.expect("its covariance"));
        for (name, i, j) in elements() {
            let std = covariance[3 * j + i][3 * j + i].sqrt();
            hold(format!("{case}, η {name}"), matrix[i][j] - number(&truth["matrix"][i][j]), std);
        }
        // A table says nothing of the five that are known.
        let Some(fourteen) = found.fourteen.filter(|fourteen| !fourteen.assumed) else { continue };
        for (name, angle) in &fourteen.angles {
            // What is known is exact or as stated; it is not found.
            if angle.std_arcsec > 0.0 {
                let off = 3600.0 * (angle.value_deg - number(&truth["angles_deg"][name]));
                hold(format!("{case}, {name}"), off, angle.std_arcsec);
            }
        }
        for (name, ratio) in &fourteen.ratios {
            let std = ratio.std().expect("an uncertainty");
            hold(format!("{case}, {name}"), ratio.value() - number(&truth["ratios"][name]), std);
        }
    }
    assert!(count >= 27 + 9 + 5, "{count}");
    assert!(worst.0 < 3.5, "{}: {:.2}", worst.1, worst.0);
}

#[test]
fn readings_in_files_beside_the_document() {
    testkit::beside(env!("CARGO_BIN_EXE_diffmag"), "diffmag/turned-pair/input.json");
}
