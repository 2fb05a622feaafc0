//! Numbers from outside. The meadow against SciPy (`fixtures/reference/scalar_scipy.py`, numpy 2 and scipy
//! 1.17); MATLAB's `magcal` by its documented example, and by NumPy on a turned ellipsoid
//! (`fixtures/reference/magcal_numpy.py`, numpy 2).

use common::Document;
use nalgebra::{Matrix3, Vector3};
use scalarcal::Options;
use serde_json::json;
use std::f64::consts::PI;

use crate::build::{self, declared, run};

/// What the documentation prints for the expected field strength.
const DOCUMENTED: f64 = 31.0723;
/// A and the expected field strength of the turned ellipsoid.
const TURNED: [[f64; 3]; 3] = [
    [1.085314518128074, 0.04933247809669512, -0.02959948685808459],
    [0.04933247809669511, 0.9373170838381403, 0.01973299123875531],
    [-0.029599486858084566, 0.019732991238755312, 0.986649561934754],
];
const TURNED_STRENGTH: f64 = 44.3992302870631;
const CENTRE: [f64; 3] = [-50.0, 20.0, 100.0];

/// 21 by 21 points of a sphere, MATLAB's `ellipsoid` in its order, as an ellipsoid about the centre.
fn points(shape: Matrix3<f64>) -> Vec<Vector3<f64>> {
    let point = |row: i32| {
        let (height, angle) = (PI * f64::from(row % 21 - 10) / 20.0, PI * f64::from(row / 21 - 10) / 10.0);
        let unit = Vector3::new(height.cos() * angle.cos(), height.cos() * angle.sin(), height.sin());
        shape * unit + Vector3::from(CENTRE)
    };
    (0..21 * 21).map(point).collect()
}

/// A², the centre and the expected field strength, in µT, by scalarcal.
fn found(points: &[Vector3<f64>]) -> (Matrix3<f64>, Vector3<f64>, f64) {
    let column = |axis: usize| points.iter().map(|point| 1000.0 * point[axis]).collect::<Vec<f64>>();
    let document = json!({"fluxcal": 1, "recordings": [{"id": "ellipsoid", "procedure": "free_run",
        "columns": {"sensor_x_nt": column(0), "sensor_y_nt": column(1), "sensor_z_nt": column(2)}}]});
    let document = Document::parse(&document.to_string()).expect("a document");
    let options = Options { constant_magnitude: true, ..Options::default() };
    let calibration = run(document, &options).calibration.expect("a calibration");
    let sensors = calibration.sensors.expect("sensors");
    let (mut k, mut offset) = (Matrix3::zeros(), Vector3::zeros());
    for (axis, sensor) in sensors.iter() {
        let place = axis.index();
        k[(place, place)] = sensor.sensitivity_nt_per_nt.as_ref().expect("a sensitivity").value();
        offset[place] = sensor.offset_nt.as_ref().expect("an offset").value() / 1000.0;
    }
    let matrix = calibration.axes.expect("axes").sensors.expect("sensors").matrix.expect("a matrix");
    let mu = Matrix3::from_fn(|i, j| matrix[i][j]);
    let form = k * (mu.transpose() * mu).try_inverse().expect("three axes") * k;
    let unit = form.determinant().cbrt();
    let scalar = calibration.scalar.expect("a calibration");
    let magnitude =
        scalar.parameters.iter().find(|one| one.name == "magnitude of the field").expect("a magnitude");
    (form / unit, -(k.try_inverse().expect("sensitivities") * offset), magnitude.value / 1000.0 / unit.sqrt())
}

fn hold(points: &[Vector3<f64>], a: Matrix3<f64>, strength: f64, within: f64) {
    let (square, centre, found) = found(points);
    assert!((square - a * a).abs().max() < 1e-9, "{square} for {}", a * a);
    assert!((centre - Vector3::from(CENTRE)).abs().max() < 1e-9 * 100.0, "{centre}");
    assert!((found / strength - 1.0).abs() < within, "{found} for {strength}");
}

#[test]
fn the_example_of_the_documentation() {
    let radii = Vector3::new(30.0, 20.0, 50.0);
    let strength = f64::cbrt(radii.product());
    let a = Matrix3::from_diagonal(&radii.map(|radius| strength / radius));
    // Printed to six digits.
    hold(&points(Matrix3::from_diagonal(&radii)), a, DOCUMENTED, 0.5e-4 / DOCUMENTED);
    hold(&points(Matrix3::from_diagonal(&radii)), a, strength, 1e-9);
}

#[test]
fn an_ellipsoid_that_is_turned() {
    let shape = Matrix3::new(1.1, 0.05, -0.03, 0.05, 0.95, 0.02, -0.03, 0.02, 1.0);
    let shape = shape.try_inverse().expect("a shape") * 45.0;
    let a = Matrix3::from_fn(|i, j| TURNED[i][j]);
    hold(&points(shape), a, TURNED_STRENGTH, 1e-9);
}

/// Values and standard uncertainties.
const SCIPY: [(f64, f64); 9] = [
    (6412.782424947416, 0.012779102185380505),
    (6380.813662978486, 0.012741805425620286),
    (6406.419593383386, 0.01285598489840434),
    (12.172157416962685, 0.06776501984113262),
    (-7.870009253948713, 0.06765943414221977),
    (4.009844719091609, 0.06779777891310872),
    (1800.1969568777668, 0.6502935922603412),
    (-1080.7983142547257, 0.6507992159439069),
    (719.4967944057038, 0.6536027909950164),
];

/// The noise is declared white, as SciPy has it; the second-order term of the noise is 1e-5 nT here.
#[test]
fn values_and_uncertainties_of_scipy() {
    let document =
        Document::parse(&testkit::read_fixture("scalarcal/meadow/input.json")).expect("a document");
    let document = run(declared(document, 0.56), &Options::default());
    for ((value, std), (expected, expected_std)) in build::found(&document).iter().zip(SCIPY) {
        assert!(
            (value - expected).abs() < 0.02 * expected_std,
            "{value} where SciPy has {expected} ± {expected_std}"
        );
        assert!((std / expected_std - 1.0).abs() < 0.02, "{std} where SciPy has {expected_std}");
    }
}
