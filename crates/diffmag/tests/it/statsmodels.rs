//! The source's regression against statsmodels, and one that loses its digits by plain normal equations
//! against exact arithmetic (fixtures/reference/diffmag_statsmodels.py).

use common::{Axis, Document};
use serde_json::Value;
use testkit::reference::{number, numbers, reference};

use crate::answers;

fn fit(case: &Value) -> common::DifferentialFit {
    answers::fit(&Document::parse(&case["document"].to_string()).expect("a document"))
}

#[test]
fn coefficients_intervals_and_newey_west() {
    let case = &reference("diffmag_statsmodels")["ordinary"];
    let fit = fit(case);
    for to in Axis::ALL {
        let expected = &case["axes"][to.to_string()];
        let [coefficients, std, robust] =
            ["coefficients", "std", "std_newey_west"].map(|key| numbers(&expected[key]));
        for (i, from) in Axis::ALL.into_iter().enumerate() {
            let element = &fit.elements[&format!("{from}{to}")];
            let close = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-9;
            let off = (element.least_squares - coefficients[i]).abs();
            assert!(off < 1e-10, "{from}{to}: {off:.1e}");
            assert!(close(element.std_independent, std[i]), "{from}{to}");
            let newey_west = element.std_newey_west.expect("a std");
            // statsmodels takes the readings with their 50 000 nT, which leaves it eight digits here; see
            // estimate's own test.
            assert!(
                (newey_west / robust[i] - 1.0).abs() < 1e-7,
                "{from}{to}: {newey_west} against {}",
                robust[i]
            );
        }
        let axis = fit.axes.get(to).expect("an axis");
        assert!((axis.rms_nt / number(&expected["rms"]) - 1.0).abs() < 1e-9);
        for (found, expected) in
            axis.rms_interval_independent_nt.iter().zip(numbers(&expected["rms_interval"]))
        {
            assert!((found / expected - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn a_small_difference_in_the_whole_field_of_the_earth() {
    let case = &reference("diffmag_statsmodels")["nasty"];
    let fit = fit(case);
    for to in Axis::ALL {
        let coefficients = numbers(&case["axes"][to.to_string()]["coefficients"]);
        for (i, from) in Axis::ALL.into_iter().enumerate() {
            let element = &fit.elements[&format!("{from}{to}")];
            let off = (element.least_squares - coefficients[i]).abs();
            // The readings themselves have 7e-12 nT of 50 000 nT.
            assert!(off < 1e-3 * element.std_independent, "{from}{to}: {off:.1e}");
            assert!(off < 1e-9, "{from}{to}: {off:.1e}");
        }
    }
}
