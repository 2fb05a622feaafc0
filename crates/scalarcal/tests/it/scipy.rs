//! The meadow against SciPy (`fixtures/reference/scalar_scipy.py`, numpy 2 and scipy 1.17).

use common::Document;
use scalarcal::Options;

use crate::build::{declared, found, run};

const VALUES: [f64; 9] = [
    6412.782424947416,
    6380.813662978486,
    6406.419593383386,
    12.172157416962685,
    -7.870009253948713,
    4.009844719091609,
    1800.1969568777668,
    -1080.7983142547257,
    719.4967944057038,
];
const STD: [f64; 9] = [
    0.012779102185380505,
    0.012741805425620286,
    0.01285598489840434,
    0.06776501984113262,
    0.06765943414221977,
    0.06779777891310872,
    0.6502935922603412,
    0.6507992159439069,
    0.6536027909950164,
];

/// The noise is declared white, as SciPy has it; the second-order term of the noise is 1e-5 nT here.
#[test]
fn values_and_uncertainties() {
    let document =
        Document::parse(&testkit::read_fixture("scalarcal/meadow/input.json")).expect("a document");
    let document = run(declared(document, 0.56), &Options::default());
    for (((value, std), expected), expected_std) in found(&document).iter().zip(VALUES).zip(STD) {
        assert!(
            (value - expected).abs() < 0.02 * expected_std,
            "{value} where SciPy has {expected} ± {expected_std}"
        );
        assert!((std / expected_std - 1.0).abs() < 0.02, "{std} where SciPy has {expected_std}");
    }
}
