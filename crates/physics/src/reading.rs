//! One reading of one sensor, with its derivatives.

use nalgebra::{Matrix3, Vector3};

use crate::Real;

/// B_geo = η b + ambient, b along each coil's axis; GEO, nT.
pub fn field_geo<T: Real>(eta: &Matrix3<T>, coil_nt: &Vector3<T>, ambient_nt: &Vector3<T>) -> Vector3<T> {
    let along = |i: usize| eta[(i, 0)] * coil_nt[0] + eta[(i, 1)] * coil_nt[1] + eta[(i, 2)] * coil_nt[2];
    Vector3::from_fn(|i, _| along(i) + ambient_nt[i])
}

/// B_par = m · B_sen: what a sensor along the unit vector m (SEN) sees, nT (NASA eq. 4).
pub fn parallel<T: Real>(m: &Vector3<T>, field_sen: &Vector3<T>) -> T {
    m[0] * field_sen[0] + m[1] * field_sen[1] + m[2] * field_sen[2]
}

/// A reading in nT and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// m · R B_geo, nT.
    pub value: f64,
    /// By the sensor's vector m: the field in SEN, nT.
    pub by_sensor: Vector3<f64>,
    /// By the field in GEO: Rᵀ m; times a coil's field it is the derivative by that coil's vector.
    pub by_field: Vector3<f64>,
    /// By a small rotation ρ of the block, R → exp([ρ]×) R, nT/rad: B_sen × m.
    pub by_rotation: Vector3<f64>,
}

/// The reading m · R B_geo of a sensor along m (SEN) in the field B_geo (GEO, nT) (NASA eq. 12).
pub fn reading(m: &Vector3<f64>, rotation: &Matrix3<f64>, field_geo: &Vector3<f64>) -> Reading {
    let field_sen = rotation * field_geo;
    Reading {
        value: parallel(m, &field_sen),
        by_sensor: field_sen,
        by_field: rotation.transpose() * m,
        by_rotation: field_sen.cross(m),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{small_rotation, turned};
    use proptest::prelude::*;

    #[test]
    fn nasa_table_4_first_measurement() {
        // Tables 2 and 4: sensor 1 and coil 1 with R = 1 give .998750.
        let m = Vector3::new(0.99975, 0.01, 0.02);
        let n = Vector3::new(0.9983, -0.03, 0.05);
        assert!((reading(&m, &Matrix3::identity(), &n).value - 0.998_750).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn derivatives(angles in prop::array::uniform3(-3.0..3.0f64), m in prop::array::uniform3(-1.0..1.0f64), b in prop::array::uniform3(-5e4..5e4f64)) {
            prop_assume!(Vector3::from(m).norm() > 0.1);
            let m: Vector3<f64> = Vector3::from(m).normalize();
            let rotation = small_rotation(&Vector3::from(angles));
            let field = Vector3::from(b);
            let at = reading(&m, &rotation, &field);
            let step = 1e-5;
            for k in 0..3 {
                let e = Vector3::ith(k, step);
                let by_rotation = (reading(&m, &(small_rotation(&e) * rotation), &field).value
                    - reading(&m, &(small_rotation(&-e) * rotation), &field).value) / (2.0 * step);
                prop_assert!((by_rotation - at.by_rotation[k]).abs() < 1e-3);
                let by_field = (reading(&m, &rotation, &(field + e)).value - reading(&m, &rotation, &(field - e)).value) / (2.0 * step);
                prop_assert!((by_field - at.by_field[k]).abs() < 1e-4);
            }
            let ahead = turned(&m, [step, 0.0]);
            let behind = turned(&m, [-step, 0.0]);
            let numeric = (reading(&ahead, &rotation, &field).value - reading(&behind, &rotation, &field).value) / (2.0 * step);
            let [e1, _] = crate::frames::tangents(&m);
            prop_assert!((numeric - at.by_sensor.dot(&e1)).abs() < 1e-3);
        }
    }
}
