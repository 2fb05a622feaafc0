//! Sensors and cameras by the twelve coefficients: d = M y + m₀ = C μ⁻ᵀ (k y + O), with C the turn from SEN to the first
//! camera.

use nalgebra::{Matrix3, Vector3};
use physics::frames::polar;

use crate::Error;
use crate::layout::FIELD_NT;

pub fn no_axes() -> Error {
    Error::Unanswerable("the sensors lie in a plane, or are left-handed: one reads the field with the opposite sign, or two are exchanged; check the columns".into())
}

/// What the twelve coefficients say.
#[derive(Clone, Debug)]
pub struct Axes {
    /// nT of the field for one of the reading, of each sensor.
    pub k: Vector3<f64>,
    pub offset_nt: Vector3<f64>,
    /// The directions of the sensors in SEN.
    pub mu: Matrix3<f64>,
    /// C, SEN to the first camera.
    pub turn: Matrix3<f64>,
    /// M, and m₀ below.
    pub linear: Matrix3<f64>,
    pub constant: Vector3<f64>,
}

impl Axes {
    /// Of the twelve coefficients, by components; SEN is the frame in which the sensors are nearest to directions that
    /// are stated. None where they lie in a plane or are left-handed.
    pub fn of(twelve: &[f64], stated: &Matrix3<f64>) -> Option<Self> {
        let linear = Matrix3::from_fn(|i, j| twelve[4 * i + j] / FIELD_NT);
        let constant = Vector3::new(twelve[3], twelve[7], twelve[11]);
        // The rows of M⁻¹ are the directions of the sensors in the camera's frame over k.
        let inverse = linear.try_inverse()?;
        let lengths = Vector3::from_fn(|i, _| inverse.row(i).norm());
        let seen = Matrix3::from_fn(|i, j| inverse[(j, i)] / lengths[j]);
        let turn = polar(&(seen * stated.transpose())).filter(|turn| turn.determinant() > 0.0)?;
        let k = lengths.map(|length| 1.0 / length);
        let (offset_nt, mu) = (seen.transpose() * constant, turn.transpose() * seen);
        Some(Self { k, offset_nt, mu, turn, linear, constant })
    }

    /// What one nT along a sensor is in the frame of the first camera: C μ⁻ᵀ eₖ.
    pub fn unit(&self, k: usize) -> Vector3<f64> {
        self.linear.column(k) / self.k[k]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn coefficients_are_taken_apart() {
        let turn = *Rotation3::from_euler_angles(0.3, -1.0, 2.0).matrix();
        let mut mu = Matrix3::new(1.0, 2e-4, -1e-4, -1e-4, 1.0, 3e-4, 2e-4, -2e-4, 1.0);
        mu.column_iter_mut().for_each(|mut column| column /= column.norm());
        let mu = polar(&mu).expect("axes").transpose() * mu;
        let (k, offset) = (Vector3::new(1.001, 0.999, 1.0005), Vector3::new(3.0, -2.0, 5.0));
        let unmixed = mu.transpose().try_inverse().expect("axes");
        let linear = turn * unmixed * Matrix3::from_diagonal(&k);
        let constant = turn * unmixed * offset;
        let twelve: Vec<f64> = (0..3)
            .flat_map(|i| (0..4).map(move |j| if j < 3 { linear[(i, j)] * FIELD_NT } else { constant[i] }))
            .collect();
        let found = Axes::of(&twelve, &Matrix3::identity()).expect("axes");
        assert!((found.k - k).norm() < 1e-12 && (found.offset_nt - offset).norm() < 1e-9);
        assert!((found.turn - turn).norm() < 1e-7, "{}", found.turn - turn);
        assert!((found.mu - mu).norm() < 1e-7);
    }
}
