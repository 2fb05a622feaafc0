//! The source's iteration against SciPy's least-squares fit of all unknowns together
//! (fixtures/reference/diffmag_drift.py).

use common::Document;
use serde_json::{Map, Value, json};

#[test]
fn the_iteration_ends_at_the_joint_least_squares() {
    let text = testkit::read_fixture("reference/diffmag_drift.json");
    let reference: Value = serde_json::from_str(&text).expect("the fixture is JSON");
    let pair = &reference["pair"];
    let rows = pair["test"][0].as_array().expect("a column").len();
    let step_s = pair["step_s"].as_f64().expect("a step");
    let mut columns = Map::new();
    columns.insert("time_s".into(), json!((0..rows).map(|row| row as f64 * step_s).collect::<Vec<_>>()));
    for (i, axis) in ["x", "y", "z"].iter().enumerate() {
        for of in ["reference", "test"] {
            columns.insert(format!("{of}_{axis}_nt"), pair[of][i].clone());
        }
    }
    let document = json!({"fluxcal": 1, "recordings": [{"id": "pair", "procedure": "differential", "columns": columns}]});
    let document = Document::parse(&document.to_string()).expect("a document");
    let found = diffmag::run(document, &diffmag::Options::default()).expect("fitted");
    let fit = found.calibration.expect("a calibration").differential.expect("a fit").fit.expect("a fit");
    let mut worst: f64 = 0.0;
    for ((_, of), expected) in fit.axes.iter().zip(pair["fits"].as_array().expect("fits")) {
        let iteration = of.drift.iteration.as_ref().expect("an iteration");
        assert!(iteration.settled);
        let number = |value: &Value| value.as_f64().expect("a number");
        let mut differ = |found: f64, expected: f64, scale: f64| {
            worst = worst.max((found - expected).abs() / scale);
        };
        for i in 0..3 {
            differ(iteration.eta[i], number(&expected["eta"][i]), 1.0);
        }
        for (found, key) in [
            (iteration.straight_nt_per_day, "straight_nt_per_day"),
            (iteration.amplitude_nt, "amplitude_nt"),
            (iteration.time_constant_s, "time_constant_s"),
        ] {
            differ(found, number(&expected[key]), number(&expected[key]).abs());
        }
        println!("{} rounds, {:.2?} from the joint fit", iteration.rounds, iteration.from_joint_std);
    }
    println!("largest relative difference: {worst:.1e}");
    assert!(worst < 1e-6);
}
