//! The field of a magnetic dipole.

use nalgebra::Vector3;

/// Field of a dipole at a place away from it, in units of μ₀/4π:
///
/// ```text
/// B = (3 n (n · m) − m) / r³,   n = r / |r|
/// ```
///
/// Source: Jackson, Classical Electrodynamics, section 5.6.
pub fn field(moment: &Vector3<f64>, place: &Vector3<f64>) -> Vector3<f64> {
    let (r, n) = (place.norm(), place.normalize());
    (3.0 * n * n.dot(moment) - moment) / r.powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On the axis 2 m/r³ along the moment, beside it m/r³ against it.
    #[test]
    fn on_the_axis_and_beside_it() {
        let moment = Vector3::new(0.0, 0.0, 5.0);
        let above = field(&moment, &Vector3::new(0.0, 0.0, 2.0));
        let beside = field(&moment, &Vector3::new(2.0, 0.0, 0.0));
        assert!((above - Vector3::new(0.0, 0.0, 1.25)).norm() < 1e-12);
        assert!((beside - Vector3::new(0.0, 0.0, -0.625)).norm() < 1e-12);
    }

    /// Two magnetic charges close together have the dipole's field far away.
    #[test]
    fn two_charges_seen_from_afar() {
        let (apart, place) = (Vector3::new(0.01, 0.02, -0.01), Vector3::new(3.0, -2.0, 4.0));
        let charge = |at: Vector3<f64>| (place - at) / (place - at).norm().powi(3);
        let exact = charge(0.5 * apart) - charge(-0.5 * apart);
        let found = field(&apart, &place);
        assert!((found - exact).norm() < 1e-4 * exact.norm(), "{found} for {exact}");
    }
}
