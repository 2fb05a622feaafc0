//! Directions as small maps of the sphere around the nominal axes.

use common::{AxesDirections, Axis, Matrix3x3};

use crate::plot::{self, Dimension, Mark, Plot, Series};

const ARCSEC_PER_RAD: f64 = 180.0 * 3600.0 / std::f64::consts::PI;
const LEVEL: f64 = 0.95;

/// Two maps: where each direction lies about its nominal axis, and the region about it in which it lies with
/// 95 %.
///
/// The first is azimuthal equidistant around each nominal axis e_i: for the direction v at the angle θ from
/// e_i the point is θ (v·e_j, v·e_k)/sin θ, with i, j, k in cyclic order. The second has the covariance of v
/// taken to the tangent plane at v.
pub fn maps(id: &str, of: &str, directions: &AxesDirections) -> Vec<Plot> {
    let note = "Across and up: the two other axes in cyclic order, for x towards y and z, for y towards z and x, for z towards x and y.";
    let arcsec = |label: &str| Dimension::linear(label, "arcsec");
    let mut nominal = Plot::new(
        format!("{id}-map"),
        format!("Directions of the {of} about their nominal axes"),
        arcsec("towards the next axis"),
        arcsec("towards the axis after it"),
    )
    .note(note);
    nominal.map = true;
    nominal.push(Series::new("nominal", Mark::Points, 4, &[0.0], &[0.0]));
    let mut regions = Plot::new(
        format!("{id}-ellipses"),
        format!("95 % regions of these directions of the {of}"),
        arcsec("towards the next axis"),
        arcsec("towards the axis after it"),
    )
    .note(
        "Each about its own direction. From the covariance of the direction, χ² with two degrees of freedom.",
    );
    regions.map = true;
    for axis in Axis::ALL {
        let Some(v) = directions.direction(axis) else { continue };
        let name = format!("{of} {axis}").replace("sensors", "sensor").replace("coils", "coil");
        let [east, north] = from_nominal(axis, v);
        nominal.push(Series::new(&name, Mark::Points, axis.index(), &[east], &[north]));
        if let Some(covariance) = tangential(directions, axis, v) {
            regions.push(plot::ellipse(&name, axis.index(), [0.0; 2], covariance, LEVEL));
        }
    }
    [nominal, regions]
        .into_iter()
        .filter(|plot| plot.series.iter().any(|series| series.name != "nominal"))
        .collect()
}

fn from_nominal(axis: Axis, v: [f64; 3]) -> [f64; 2] {
    let [i, j, k] = [0, 1, 2].map(|step| (axis.index() + step) % 3);
    let sin = v[j].hypot(v[k]);
    let scale = if sin > 0.0 { ARCSEC_PER_RAD * sin.atan2(v[i]) / sin } else { ARCSEC_PER_RAD };
    [scale * v[j], scale * v[k]]
}

/// Covariance of a direction in the tangent plane at it, arcsec²; None where none is stated.
fn tangential(directions: &AxesDirections, axis: Axis, v: [f64; 3]) -> Option<Matrix2x2> {
    let (covariance, order) = (directions.covariance.as_ref()?, directions.covariance_order.as_ref()?);
    let place = |row: usize| order.iter().position(|key| *key == format!("matrix[{row}][{}]", axis.index()));
    let places = [place(0)?, place(1)?, place(2)?];
    let mut block: Matrix3x3 = [[0.0; 3]; 3];
    for (row, from) in places.iter().enumerate() {
        for (column, to) in places.iter().enumerate() {
            block[row][column] = *covariance.get(*from)?.get(*to)?;
        }
    }
    let mut next = [0.0; 3];
    next[(axis.index() + 1) % 3] = 1.0;
    let along = dot(next, v);
    let first = [0, 1, 2].map(|i| next[i] - along * v[i]);
    let length = dot(first, first).sqrt();
    let first = first.map(|component| component / length);
    let second = [0, 1, 2].map(|i| {
        let [j, k] = [(i + 1) % 3, (i + 2) % 3];
        v[j] * first[k] - v[k] * first[j]
    });
    let between = |a: [f64; 3], b: [f64; 3]| ARCSEC_PER_RAD.powi(2) * dot(a, block.map(|row| dot(row, b)));
    let across = between(first, second);
    let both = [[between(first, first), across], [across, between(second, second)]];
    both.iter().flatten().all(|number| number.is_finite()).then_some(both)
}

type Matrix2x2 = [[f64; 2]; 2];

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_direction_keeps_its_angle_and_its_side() {
        // z turned 3 degrees towards x and 4 towards y, nearly.
        let angle = 5f64.to_radians();
        let v = [0.6 * angle.sin(), 0.8 * angle.sin(), angle.cos()];
        let [x, y] = from_nominal(Axis::Z, v);
        assert!((x - 3.0 * 3600.0).abs() < 1e-6 && (y - 4.0 * 3600.0).abs() < 1e-6, "{x} {y}");
        // x turned towards z alone goes up.
        let [across, up] = from_nominal(Axis::X, [angle.cos(), 0.0, angle.sin()]);
        assert!(across.abs() < 1e-9 && (up - 5.0 * 3600.0).abs() < 1e-6);
    }

    #[test]
    fn the_covariance_of_a_nominal_direction_is_its_own_block() {
        let mut covariance = vec![vec![0.0; 9]; 9];
        // Direction y: its cosines towards z (row 2) and x (row 0), in rad².
        (covariance[5][5], covariance[3][3], covariance[5][3], covariance[3][5]) =
            (4e-12, 1e-12, 5e-13, 5e-13);
        let directions = AxesDirections {
            covariance: Some(covariance),
            covariance_order: Some((0..9).map(|k| format!("matrix[{}][{}]", k % 3, k / 3)).collect()),
            ..AxesDirections::default()
        };
        let [[a, b], [_, c]] = tangential(&directions, Axis::Y, [0.0, 1.0, 0.0]).expect("a covariance");
        let square = ARCSEC_PER_RAD * ARCSEC_PER_RAD;
        assert!(
            (a - 4e-12 * square).abs() < 1e-9
                && (b - 5e-13 * square).abs() < 1e-9
                && (c - 1e-12 * square).abs() < 1e-9
        );
    }
}
