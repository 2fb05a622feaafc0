//! MATLAB's `magcal` by its documented example, and by NumPy on a turned ellipsoid
//! (`fixtures/reference/magcal_numpy.py`, numpy 2).

use common::Document;
use nalgebra::{Matrix3, Vector3};
use scalarcal::Options;
use serde_json::json;
use std::f64::consts::PI;

use crate::build::run;

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

/// 21 by 21 points of a sphere, those of MATLAB's `ellipsoid` in its order, made an ellipsoid about the
/// centre.
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
