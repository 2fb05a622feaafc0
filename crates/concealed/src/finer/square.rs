//! The field of a pair of square windings.

use nalgebra::Vector3;

/// Distance of the windings over the length of a side at which the field about the centre is flattest.
const APART: f64 = 0.5445;

/// Field of a straight wire from one place to another at the origin, in units of μ₀ I / 4π:
///
/// ```text
/// B = a × b (|a| + |b|) / (|a| |b| (|a| |b| + a · b))
/// ```
///
/// a and b the ways from the origin to its ends. Source: Hanson and Hirshman 2002, Compact expressions for
/// the Biot-Savart fields of a filamentary segment, Phys. Plasmas 9, 4410.
fn wire(from: &Vector3<f64>, to: &Vector3<f64>) -> Vector3<f64> {
    let (a, b) = (from.norm(), to.norm());
    from.cross(to) * ((a + b) / (a * b * (a * b + from.dot(to))))
}

/// Field of a square winding with sides of length 2 about an axis, its centre at the origin, at a place.
fn winding(axis: &Vector3<f64>, place: &Vector3<f64>) -> Vector3<f64> {
    let across = if axis.x.abs() < 0.8 { Vector3::x() } else { Vector3::y() };
    let first = axis.cross(&across).normalize();
    let second = axis.cross(&first);
    let corners =
        [first + second, second - first, -first - second, first - second].map(|corner| corner - place);
    (0..4).map(|k| wire(&corners[k], &corners[(k + 1) % 4])).sum()
}

/// A pair of square windings with sides of `side_m` about the axis n, the first with 1 + ε and the second
/// with 1 − ε of the turns: its field at a place in m, in units of the field at the centre.
pub fn pair(axis: &Vector3<f64>, place_m: &Vector3<f64>, side_m: f64, excess: f64) -> Vector3<f64> {
    let at = |place: &Vector3<f64>| {
        winding(axis, &(place - APART * axis)) * (1.0 + excess)
            + winding(axis, &(place + APART * axis)) * (1.0 - excess)
    };
    at(&(place_m * (2.0 / side_m))) / at(&Vector3::zeros()).dot(axis)
}

/// Relative gradient along the axis at the centre, per m: ε (2 d / (1 + d²) + d / (2 + d²)) 2 / side, d the
/// distance of a winding over half a side.
pub fn gradient(side_m: f64, excess: f64) -> f64 {
    excess * (2.0 * APART / (1.0 + APART * APART) + APART / (2.0 + APART * APART)) * 2.0 / side_m
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On its axis a square has 8 / ((1 + z²) √(2 + z²)).
    #[test]
    fn on_the_axis_it_is_the_closed_form() {
        let axis = Vector3::new(0.2, 0.5, -0.7).normalize();
        for z in [-1.2_f64, 0.0, 0.4, 2.5] {
            let exact = axis * 8.0 / ((1.0 + z * z) * (2.0 + z * z).sqrt());
            assert!((winding(&axis, &(axis * z)) - exact).norm() < 1e-12);
        }
    }

    /// About the centre it has the gradient of a field without sources, and without an excess hardly any
    /// second derivative.
    #[test]
    fn about_the_centre_it_has_its_gradient() {
        let (axis, side, excess) = (Vector3::new(-0.3, 0.1, 0.9).normalize(), 2.2, 0.01);
        let p = axis * 1e-3;
        let found = pair(&axis, &p, side, excess) - axis;
        assert!((found.dot(&axis) / (1e-3 * gradient(side, excess)) - 1.0).abs() < 0.01, "{found}");
        let bent = pair(&axis, &(axis * 0.05), side, 0.0) - axis;
        assert!(bent.norm() < 1e-5, "{bent}");
    }
}
