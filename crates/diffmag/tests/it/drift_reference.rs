//! The source's iteration against SciPy's least-squares fit of all unknowns together
//! (fixtures/reference/diffmag_drift.py).

use common::Document;
use serde_json::{Map, json};
use testkit::reference::{list, number, reference};

use crate::answers::fit;

#[test]
fn the_iteration_ends_at_the_joint_least_squares() {
    let reference = reference("diffmag_drift");
    let pair = &reference["pair"];
    let rows = list(&pair["test"][0]).len();
    let step_s = number(&pair["step_s"]);
    let mut columns = Map::new();
    columns.insert("time_s".into(), json!((0..rows).map(|row| row as f64 * step_s).collect::<Vec<_>>()));
    for (i, axis) in ["x", "y", "z"].iter().enumerate() {
        for of in ["reference", "test"] {
            columns.insert(format!("{of}_{axis}_nt"), pair[of][i].clone());
        }
    }
    let document = json!({"fluxcal": 1, "recordings": [{"id": "pair", "procedure": "differential", "columns": columns}]});
    let fit = fit(&Document::parse(&document.to_string()).expect("a document"));
    let mut worst: f64 = 0.0;
    for ((_, of), expected) in fit.axes.iter().zip(list(&pair["fits"])) {
        let iteration = of.drift.iteration.as_ref().expect("an iteration");
        assert!(iteration.settled);
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
