//! The fourteen parameters found again, in closed form and by iteration, by SciPy, and what is refused.

use common::Magnetometer;
use diffmag::fourteen::{
    EtaCovariance, Fourteen, KnownFive, NAMES, UNDETERMINED_RAD, solve, solve_numerically,
};
use nalgebra::{Matrix3, SMatrix};
use proptest::prelude::*;
use testkit::reference::{list, numbers, reference};

use crate::pairs::{eta_of, known, parameters};

/// The answer for an exact η.
fn exact(eta: &Matrix3<f64>, known: &KnownFive) -> Fourteen {
    solve(eta, &EtaCovariance::zeros(), known).unwrap_or_else(|error| panic!("{known:?}: {error}"))
}

/// The largest difference: rad for angles, a share for ratios. An azimuth counts by the arc that it moves its
/// axis.
fn difference(found: &[f64; 14], truth: &[f64; 14]) -> f64 {
    (0..14)
        .map(|i| {
            let arc = match i {
                0 => truth[2].sin(),
                3 | 5 | 7 => truth[i + 1].sin(),
                9.. => 1.0 / truth[i],
                _ => 1.0,
            };
            ((found[i] - truth[i]) * arc).abs()
        })
        .fold(0.0, f64::max)
}

fn check(truth: &[f64; 14]) {
    let eta = eta_of(truth);
    for known in known(truth) {
        let found = exact(&eta, &known).values;
        let off = difference(&found, truth);
        assert!(off < 1e-12, "{:?}: {off:.1e}\n{found:?}\n{truth:?}", known.instrument);
        let iterated = solve_numerically(&eta, &known).unwrap_or_else(|error| panic!("{truth:?}: {error}"));
        let off = difference(&iterated, &found);
        assert!(off < 1e-12, "{:?}: iteration {off:.1e}\n{iterated:?}\n{found:?}", known.instrument);
    }
}

#[test]
fn found_again_on_a_grid_of_tilts() {
    for tilt in [0.0, 0.001, 0.1, 2.0, 8.0, 20.0] {
        for [a, b, c] in [[1.0_f64, 1.0, 1.0], [-1.0, 0.5, 0.3], [0.4, -1.0, 1.0], [0.0, 1.0, 0.0]] {
            for alpha in [-170.0, -45.0, 0.0, 100.0] {
                let degrees = [
                    alpha,
                    b * tilt,
                    a.abs() * tilt,
                    90.0 + c * tilt,
                    90.0 - a * tilt,
                    b * tilt,
                    90.0 + a * tilt,
                    -0.7 * alpha,
                    c * tilt,
                ];
                check(&parameters(degrees, [1.2, 0.9, 1.1, 1.05, 0.8]));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn found_again_in_any_attitude(
        alpha in -180.0..180.0f64, beta in -20.0..20.0f64, gamma in 0.0..20.0f64,
        heading in -180.0..180.0f64,
        lean in prop::array::uniform5(-12.0..12.0f64),
        ratios in prop::array::uniform5(0.5..2.0f64),
        unit in prop::sample::select(vec![1e-3, 1.0, 400.0]),
        reversed: bool,
    ) {
        let turn = |degrees: f64| (degrees + 180.0).rem_euclid(360.0) - 180.0;
        let degrees = [
            alpha, beta, gamma, turn(heading + 90.0), 90.0 + lean[0], turn(heading + lean[1]), 90.0 + lean[2],
            turn(lean[3] * 15.0), if reversed { 180.0 - lean[4].abs() } else { lean[4].abs() },
        ];
        let [a, b, c, d, e] = ratios;
        check(&parameters(degrees, [a * unit, b, c, d, e]));
    }
}

#[test]
fn by_hand() {
    // Reference: right angles, K = 2, 1, 4. Test: x_t along (3, 4, 0)/5 with K = 10, y_t along −x with K = 3,
    // z_t along (0, 5, 12)/13 with K = 26. Columns of η: K_tj a_jk/K_rk.
    let eta = Matrix3::new(3.0, -1.5, 0.0, 8.0, 0.0, 10.0, 0.0, 0.0, 6.0);
    let known = |instrument, values| KnownFive { instrument, values, covariance: SMatrix::zeros() };
    let found = exact(&eta, &known(Magnetometer::Reference, [0.0, 0.0, 0.0, 2.0, 4.0])).values;
    let right = std::f64::consts::FRAC_PI_2;
    let angles = [0.0, 0.0, 0.0, 0.6f64.asin(), right, -right, right, 0.0, (5.0f64 / 13.0).asin()];
    let ratios = [5.0, 2.0, 4.0, 10.0 / 3.0, 26.0 / 3.0];
    let expected = std::array::from_fn(|i| if i < 9 { angles[i] } else { ratios[i - 9] });
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() < 1e-14, "{}: {found} {expected}", NAMES[i]);
    }
    // The same from the test's own cosines: x·y = −0.6, y·z = 0, x·z = 4/13.
    let found = exact(&eta, &known(Magnetometer::Test, [-0.6, 0.0, 4.0 / 13.0, 10.0 / 3.0, 26.0 / 3.0]));
    assert!(difference(&found.values, &expected) < 1e-14, "{:?}", found.values);
}

#[test]
fn parameters_of_scipy() {
    let mut worst = 0.0_f64;
    for set in list(&reference("fourteen_scipy")) {
        let name = &set["name"];
        let rows: Vec<Vec<f64>> = list(&set["eta"]).iter().map(numbers).collect();
        let eta = Matrix3::from_fn(|i, j| rows[i][j]);
        for (case, instrument) in [("reference", Magnetometer::Reference), ("test", Magnetometer::Test)] {
            let mut values: [f64; 5] = numbers(&set[case]["known"]).try_into().expect("five");
            if instrument == Magnetometer::Reference {
                let [alpha, beta, gamma, ..] = values;
                values[..3].copy_from_slice(&[gamma.sin() * alpha.sin(), gamma.sin() * alpha.cos(), beta]);
            }
            let expected: [f64; 14] = numbers(&set[case]["values"]).try_into().expect("fourteen");
            let known = KnownFive { instrument, values, covariance: SMatrix::zeros() };
            let iterated = solve_numerically(&eta, &known).expect("an answer");
            for found in [exact(&eta, &known).values, iterated] {
                for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
                    worst = worst.max((found - expected).abs());
                    assert!(worst < 1e-9, "{name} {case} {}: {found} {expected}", NAMES[i]);
                }
            }
            assert!((eta_of(&expected) - eta).amax() < 1e-9 * eta.amax(), "{name}");
        }
    }
    println!("the largest difference is {worst:.1e}");
}

/// By differences of answers: the squares of how far the tilt of an axis, (sin γ sin α, sin γ cos α), moves with the
/// nine of η, its azimuth and polar angle being these.
fn tilts_squared(p: &[f64; 14], azimuth: usize, polar: usize) -> [f64; 2] {
    const STEP: f64 = 1e-5;
    let tilt = |k: usize, by: f64| {
        let mut eta = eta_of(p);
        eta[k] += by;
        let found = exact(&eta, &known(p)[1]).values;
        let (sin, cos) = found[azimuth].sin_cos();
        [sin, cos].map(|part| found[polar].sin() * part)
    };
    let moved = (0..9).map(|k| [tilt(k, STEP), tilt(k, -STEP)]);
    moved.fold([0.0; 2], |sum, [up, down]| {
        std::array::from_fn(|i| sum[i] + ((up[i] - down[i]) / (2.0 * STEP)).powi(2))
    })
}

#[test]
fn a_vertical_axis_has_no_azimuth() {
    let truth = parameters([0.0, 3.0, 0.0, 90.0, 90.0, 0.0, 90.0, 0.0, 0.0], [1.0, 1.1, 0.9, 1.0, 1.0]);
    let covariance = EtaCovariance::identity() * 1e-8;
    let found = solve(&eta_of(&truth), &covariance, &known(&truth)[1]).expect("an answer");
    assert_eq!(found.undetermined, ["alpha_rad", "phi_z_rad"]);
    let sigma = found.uncertainties();
    for (azimuth, polar) in [(0, 2), (7, 8)] {
        assert_eq!(sigma[azimuth], UNDETERMINED_RAD);
        let expected = 1e-8 * tilts_squared(&truth, azimuth, polar).iter().sum::<f64>();
        assert!((sigma[polar].powi(2) / expected - 1.0).abs() < 1e-8, "{}", sigma[polar]);
        assert!((0..14).all(|i| i == azimuth || found.covariance[(i, azimuth)] == 0.0));
    }
    assert!(found.values.iter().chain(found.covariance.iter()).all(|value| value.is_finite()));
    // The same tilt and more than its uncertainty: the azimuth is there again.
    let mut tilted = truth;
    tilted[2] = 0.01;
    let found = solve(&eta_of(&tilted), &covariance, &known(&tilted)[1]).expect("an answer");
    assert_eq!(found.undetermined, ["phi_z_rad"]);
    let across = 1e-4 * tilts_squared(&tilted, 0, 2)[0].sqrt();
    assert!((found.uncertainties()[0] * 0.01_f64.sin() / across - 1.0).abs() < 1e-6);
}

#[test]
fn what_cannot_be_is_refused() {
    let truth = parameters([20.0, 3.0, 4.0, 91.0, 88.0, 2.0, 90.0, 5.0, 6.0], [1.0, 1.1, 0.9, 1.0, 1.0]);
    let eta = eta_of(&truth);
    let none = EtaCovariance::zeros();
    let refused = |eta: &Matrix3<f64>, covariance: &EtaCovariance, known: &KnownFive, words: &str| {
        let message = solve(eta, covariance, known).expect_err(words).to_string();
        assert!(message.contains(words), "{message}");
    };
    let [known, _] = known(&truth);
    let flat = Matrix3::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0);
    refused(&flat, &none, &known, "η is singular");
    refused(&Matrix3::zeros(), &none, &known, "η is singular");
    refused(&(eta * f64::NAN), &none, &known, "η is singular");
    refused(&eta, &(EtaCovariance::identity() * 0.25), &known, "output is dead");
    let mut crooked = none;
    crooked[(0, 1)] = 1.0;
    refused(&eta, &crooked, &known, "larger than its variances allow");
    refused(&eta, &-EtaCovariance::identity(), &known, "variance 1 is −1");
    let with = |instrument, values| KnownFive { instrument, values, ..known.clone() };
    use Magnetometer::{Reference, Test};
    for (instrument, values, words) in [
        (Test, [0.9, 0.9, -0.9, 1.0, 1.0], "positive definite"),
        (Test, [0.0, 1.0, 0.0, 1.0, 1.0], "positive definite"),
        (Test, [0.0, 0.0, 0.0, 1.0, -1.0], "a ratio of -1"),
        (Reference, [0.0, 0.0, f64::INFINITY, 1.0, 1.0], "five finite numbers"),
        (Reference, [0.8, 0.7, 0.0, 1.0, 1.0], "less than 90°"),
    ] {
        refused(&eta, &none, &with(instrument, values), words);
    }
    assert!(solve_numerically(&flat, &known).is_err());
    assert!(solve_numerically(&eta, &with(Test, [0.9, 0.9, -0.9, 1.0, 1.0])).is_err());
}
