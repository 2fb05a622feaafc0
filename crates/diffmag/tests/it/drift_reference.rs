//! The source's iteration against SciPy's least-squares fit of all unknowns together
//! (fixtures/reference/diffmag_drift.py).

use testkit::reference::{list, number, numbers, reference};

use crate::answers::fit;
use crate::pair_in_time::{both, document};

#[test]
fn the_iteration_ends_at_the_joint_least_squares() {
    let reference = reference("diffmag_drift");
    let pair = &reference["pair"];
    let read = |of: &str| -> [Vec<f64>; 3] { std::array::from_fn(|i| numbers(&pair[of][i])) };
    let (reference, test) = (read("reference"), read("test"));
    let (rows, step_s) = (test[0].len(), number(&pair["step_s"]));
    let time: Vec<f64> = (0..rows).map(|row| row as f64 * step_s).collect();
    let fit = fit(&document(vec![both("pair", &time, [&reference, &test], &(0..rows))]));
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
