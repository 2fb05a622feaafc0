//! Directions as small maps of the sphere around the nominal axes.

use common::{AxesDirections, Axis};
use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector3};

use crate::plot::{Mark, Plot, Point, Series};

const ARCSEC_PER_RAD: f64 = 180.0 * 3600.0 / std::f64::consts::PI;
const LEVEL: f64 = 0.95;

/// Two maps: where each direction lies about its nominal axis, and the region about it in which it lies with
/// 95 %.
///
/// The first is azimuthal equidistant around each nominal axis e_i: for the direction v at the angle θ from
/// e_i the point is θ (v·e_j, v·e_k)/sin θ, with i, j, k in cyclic order. The second has the covariance of v
/// taken to the tangent plane at v.
pub fn maps(id: &str, of: &str, directions: &AxesDirections) -> Vec<Plot> {
    let map = |end: &str, title: String, note: &str| {
        let plot = Plot::new(format!("{id}-{end}"), title).note(note);
        let plot = plot.axes("towards the next axis [arcsec]", "towards the axis after it [arcsec]");
        Plot { map: true, ..plot }
    };
    let mut nominal = map(
        "map",
        format!("Directions of the {of} about their nominal axes"),
        "Across and up: the two other axes in cyclic order, for x towards y and z, for y towards z and x, for z towards x and y.",
    );
    nominal.push(Series::points("nominal", 4, &[0.0], &[0.0]));
    let mut regions = map(
        "ellipses",
        format!("95 % regions of these directions of the {of}"),
        "Each about its own direction. From the covariance of the direction, χ² with two degrees of freedom.",
    );
    for axis in Axis::ALL {
        let Some(v) = directions.direction(axis) else { continue };
        let name = format!("{of} {axis}").replace("sensors", "sensor").replace("coils", "coil");
        let [east, north] = from_nominal(axis, v);
        nominal.push(Series::points(&name, axis.index(), &[east], &[north]));
        if let Some(covariance) = tangential(directions, axis, v) {
            let points = ellipse(covariance);
            regions.push(Series { name, mark: Mark::Line, style: axis.index(), points });
        }
    }
    let is_drawn = |plot: &Plot| plot.series.iter().any(|series| series.name != "nominal");
    [nominal, regions].into_iter().filter(is_drawn).collect()
}

/// The region about zero of two quantities with this covariance: pᵀ C⁻¹ p = −2 ln(1 − level), the χ² of two
/// degrees of freedom.
fn ellipse(covariance: Matrix2<f64>) -> Vec<Point> {
    const POINTS: usize = 72;
    let radius = (-2.0 * (1.0 - LEVEL).ln()).sqrt();
    // Cholesky factor of the covariance; rounding may leave a variance a little below zero.
    let a = covariance[(0, 0)].max(0.0).sqrt();
    let b = if a > 0.0 { covariance[(1, 0)] / a } else { 0.0 };
    let c = (covariance[(1, 1)] - b * b).max(0.0).sqrt();
    let point = |n: usize| {
        let (sin, cos) = (n as f64 / POINTS as f64 * std::f64::consts::TAU).sin_cos();
        Point { x: radius * a * cos, y: radius * (b * cos + c * sin), bar: None }
    };
    (0..=POINTS).map(point).collect()
}

fn from_nominal(axis: Axis, v: [f64; 3]) -> [f64; 2] {
    let [i, j, k] = [0, 1, 2].map(|step| (axis.index() + step) % 3);
    let sin = v[j].hypot(v[k]);
    let scale = if sin > 0.0 { ARCSEC_PER_RAD * sin.atan2(v[i]) / sin } else { ARCSEC_PER_RAD };
    [scale * v[j], scale * v[k]]
}

/// Covariance of a direction in the tangent plane at it, arcsec²; None where none is stated.
fn tangential(directions: &AxesDirections, axis: Axis, v: [f64; 3]) -> Option<Matrix2<f64>> {
    let (covariance, order) = (directions.covariance.as_ref()?, directions.covariance_order.as_ref()?);
    let place = |row: usize| order.iter().position(|key| *key == format!("matrix[{row}][{}]", axis.index()));
    let places = [place(0)?, place(1)?, place(2)?];
    let entry = |i: usize, j: usize| covariance.get(places[i])?.get(places[j]).copied();
    let block = Matrix3::from_fn(|i, j| entry(i, j).unwrap_or(f64::NAN));
    let (v, next) = (Vector3::from(v), Vector3::ith((axis.index() + 1) % 3, 1.0));
    let first = (next - v * next.dot(&v)).normalize();
    let tangents = Matrix3x2::from_columns(&[first, v.cross(&first)]);
    let both = tangents.transpose() * block * tangents * ARCSEC_PER_RAD.powi(2);
    both.iter().all(|entry| entry.is_finite()).then_some(both)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_keeps_its_angle_and_its_side() {
        // z turned 3 degrees towards x and 4 towards y, nearly.
        let angle = 5f64.to_radians();
        let [x, y] = from_nominal(Axis::Z, [0.6 * angle.sin(), 0.8 * angle.sin(), angle.cos()]);
        assert!((x - 3.0 * 3600.0).abs() < 1e-6 && (y - 4.0 * 3600.0).abs() < 1e-6, "{x} {y}");
        // x turned towards z alone goes up.
        let [across, up] = from_nominal(Axis::X, [angle.cos(), 0.0, angle.sin()]);
        assert!(across.abs() < 1e-9 && (up - 5.0 * 3600.0).abs() < 1e-6);
    }

    /// Direction y: its cosines towards z (row 2) and x (row 0), in rad². Every point of the ellipse has the same
    /// Mahalanobis distance, 5.991, the 95 % point of χ² with two degrees of freedom.
    #[test]
    fn the_covariance_of_a_nominal_direction_is_its_own_block() {
        let mut covariance = vec![vec![0.0; 9]; 9];
        (covariance[5][5], covariance[3][3], covariance[5][3], covariance[3][5]) =
            (4e-12, 1e-12, 1.5e-12, 1.5e-12);
        let directions = AxesDirections {
            covariance: Some(covariance),
            covariance_order: Some((0..9).map(|k| format!("matrix[{}][{}]", k % 3, k / 3)).collect()),
            ..AxesDirections::default()
        };
        let found = tangential(&directions, Axis::Y, [0.0, 1.0, 0.0]).expect("a covariance");
        let [p, q, r] = [4e-12, 1.5e-12, 1e-12].map(|entry| entry * ARCSEC_PER_RAD * ARCSEC_PER_RAD);
        assert!((found - Matrix2::new(p, q, q, r)).amax() < 1e-9, "{found}");
        for Point { x, y, .. } in ellipse(found) {
            let squared = (r * x * x - 2.0 * q * x * y + p * y * y) / (p * r - q * q);
            assert!((squared - 5.991_464_547).abs() < 1e-6, "{squared}");
        }
    }
}
