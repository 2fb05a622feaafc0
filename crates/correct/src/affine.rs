//! The correction where no effect acts behind the field: a matrix, and a quadratic form for its uncertainty.

use nalgebra::{Matrix3, SMatrix, Vector3, Vector4};
use physics::{Direction, Error, Inverter};

/// B = M y + o and the covariance of B, whose six elements are quadratic forms of (y, 1); y in the unit of
/// the recording.
pub struct Affine {
    matrix: SMatrix<f64, 3, 4>,
    /// For the elements xx, yy, zz, xy, yz, zx.
    forms: [SMatrix<f64, 4, 4>; 6],
}

/// Rows and columns of those elements.
const ELEMENTS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

impl Affine {
    /// From the field of four readings and its derivatives, which determine all others. `sources` are those
    /// of [`crate::known`]; `noise_nt2` is the variance of one reading of each sensor.
    pub fn of(inverter: Inverter<'_>, sources: &[Direction], noise_nt2: Vector3<f64>) -> Result<Self, Error> {
        let mut readings = vec![Vector3::zeros()];
        readings.extend((0..3).map(|k| Vector3::ith(k, 1.0)));
        let solved = inverter.field(&readings)?;
        let affine = |rows: &[Vector3<f64>]| {
            SMatrix::<f64, 3, 4>::from_columns(&[
                rows[1] - rows[0],
                rows[2] - rows[0],
                rows[3] - rows[0],
                rows[0],
            ])
        };
        let mut forms = [SMatrix::zeros(); 6];
        for moved in solved.along(sources)? {
            let moved = affine(&moved);
            for (form, (i, j)) in forms.iter_mut().zip(ELEMENTS) {
                let product = moved.row(i).transpose() * moved.row(j);
                *form += (product + product.transpose()) / 2.0;
            }
        }
        let noise = solved.covariance_of_readings(noise_nt2)?[0];
        for (form, (i, j)) in forms.iter_mut().zip(ELEMENTS) {
            form[(3, 3)] += noise[(i, j)];
        }
        Ok(Self { matrix: affine(&solved.field_sen), forms })
    }

    /// The field in SEN, nT, and its covariance, nT².
    pub fn field(&self, reading: &Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
        let y: Vector4<f64> = reading.push(1.0);
        let mut covariance = Matrix3::zeros();
        for (form, (i, j)) in self.forms.iter().zip(ELEMENTS) {
            let value = y.dot(&(form * y));
            (covariance[(i, j)], covariance[(j, i)]) = (value, value);
        }
        (self.matrix * y, covariance)
    }
}
