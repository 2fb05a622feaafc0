//! The field of a pair of round windings, away from its centre.

use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Pieces that a winding is cut into.
const PIECES: usize = 60;

/// Field of one round winding of radius 1 about the axis n through its centre, at a place from there, in
/// units of μ₀ I / 4π:
///
/// ```text
/// B = ∮ dl × r / r³
/// ```
///
/// in sixty pieces; the sum over a whole round converges faster than any power. Source: Jackson, Classical
/// Electrodynamics, section 5.2.
fn winding(axis: &Vector3<f64>, place: &Vector3<f64>) -> Vector3<f64> {
    let across = if axis.x.abs() < 0.8 { Vector3::x() } else { Vector3::y() };
    let first = axis.cross(&across).normalize();
    let second = axis.cross(&first);
    let step = TAU / PIECES as f64;
    let piece = |k: usize| {
        let (sin, cos) = (step * k as f64).sin_cos();
        let to = place - (first * cos + second * sin);
        (second * cos - first * sin).cross(&to) * step / to.norm().powi(3)
    };
    (0..PIECES).map(piece).sum()
}

/// Helmholtz's pair of radius `radius_m` about the axis n, the windings at ± n R/2, the first with 1 + ε and
/// the second with 1 − ε of the turns: its field at a place in m, in units of the field at the centre.
pub fn pair(axis: &Vector3<f64>, place_m: &Vector3<f64>, radius_m: f64, excess: f64) -> Vector3<f64> {
    let place = place_m / radius_m;
    let upper = winding(axis, &(place - 0.5 * axis)) * (1.0 + excess);
    let lower = winding(axis, &(place + 0.5 * axis)) * (1.0 - excess);
    // On its axis at half a radius one winding has 2π / 1.25^(3/2), and at the centre the two of them have
    // twice that whatever ε.
    (upper + lower) / (2.0 * TAU / 1.25_f64.powf(1.5))
}

/// Relative gradient along the axis at the centre, per m: 6 ε / 5 R.
pub fn gradient(radius_m: f64, excess: f64) -> f64 {
    1.2 * excess / radius_m
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On the axis a winding has 2π / (1 + z²)^(3/2).
    #[test]
    fn on_the_axis_it_is_the_closed_form() {
        let axis = Vector3::new(0.3, -0.5, 0.8).normalize();
        for z in [-1.0_f64, -0.2, 0.0, 0.7, 3.0] {
            let exact = axis * TAU / (1.0 + z * z).powf(1.5);
            assert!((winding(&axis, &(axis * z)) - exact).norm() < 1e-12);
        }
    }

    /// At the centre 1, and about it the gradient of a field without sources: g (3 n (n · p) − p) / 2.
    #[test]
    fn about_the_centre_it_has_its_gradient() {
        let (axis, radius, excess) = (Vector3::new(0.1, 0.9, -0.2).normalize(), 0.8, 0.01);
        let level = pair(&axis, &Vector3::zeros(), radius, excess);
        assert!((level - axis).norm() < 1e-12, "{level}");
        let p = Vector3::new(4e-3, -3e-3, 5e-3);
        let linear = gradient(radius, excess) * 0.5 * (3.0 * axis * axis.dot(&p) - p);
        let found = pair(&axis, &p, radius, excess) - level;
        assert!((found - linear).norm() < 0.02 * linear.norm(), "{found} for {linear}");
    }
}
