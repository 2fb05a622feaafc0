//! The fourteen parameters as SciPy finds them from the nonlinear equations.

use diffmag::fourteen::{EtaCovariance, KnownAxes, KnownFive, NAMES, eta_of, solve, solve_numerically};
use nalgebra::{Matrix3, SMatrix};
use testkit::reference::{list, numbers, reference};

#[test]
fn parameters_of_scipy() {
    let sets = reference("fourteen_scipy");
    let mut worst = 0.0_f64;
    for set in list(&sets) {
        let name = &set["name"];
        let rows: Vec<Vec<f64>> = list(&set["eta"]).iter().map(numbers).collect();
        let eta = Matrix3::from_fn(|i, j| rows[i][j]);
        for case in ["reference", "test"] {
            let five = numbers(&set[case]["known"]);
            let expected = numbers(&set[case]["values"]);
            let three = [five[0], five[1], five[2]];
            let axes = if case == "test" { KnownAxes::Test(three) } else { KnownAxes::Reference(three) };
            let known = KnownFive { axes, ratios: [five[3], five[4]], covariance: SMatrix::zeros() };
            let closed = solve(&eta, &EtaCovariance::zeros(), &known).expect("an answer").values;
            let iterated = solve_numerically(&eta, &known).expect("an answer");
            for (i, expected) in expected.iter().enumerate() {
                for found in [closed[i], iterated[i]] {
                    worst = worst.max((found - expected).abs());
                    assert!(
                        (found - expected).abs() < 1e-9,
                        "{name} {case} {}: {found} {expected}",
                        NAMES[i]
                    );
                }
            }
            let values: [f64; 14] = std::array::from_fn(|i| expected[i]);
            assert!((eta_of(&values) - eta).amax() < 1e-9 * eta.amax(), "{name}");
        }
    }
    println!("the largest difference is {worst:.1e}");
}
