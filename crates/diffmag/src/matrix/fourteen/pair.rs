//! The two instruments as smooth quantities: axes as unit vectors, which have no pole.

use nalgebra::{Matrix3, Vector3};
use physics::Real;

use super::parameters::{ANGLES, BETA, RATIOS};

/// A pair of instruments, or the derivative of one.
#[derive(Clone, Debug)]
pub(super) struct Pair<T: Real = f64> {
    /// β, rad.
    pub beta: T,
    /// Unit vectors in the frame: Z_r and the test's x, y, z.
    pub axes: [Vector3<T>; 4],
    /// K_xt/K_xr, K_xr/K_yr, K_zr/K_yr, K_xt/K_yt, K_zt/K_yt.
    pub ratios: [T; 5],
}

impl<T: Real> Pair<T> {
    /// K_tj/K_yr of the test's three axes.
    fn test_factors(&self) -> [T; 3] {
        let [xt_xr, xr_yr, _, xt_yt, zt_yt] = self.ratios;
        let x = xt_xr * xr_yr;
        let y = x / xt_yt;
        [x, y, y * zt_yt]
    }

    /// η_ij = K_tj a_j · c_i with c_i the columns of M_r⁻¹: the field for a reading of one on axis i of the
    /// reference,
    ///
    /// ```text
    /// B_x = B_xr/cos β − B_yr tan β
    /// B_y = B_yr
    /// B_z = B_zr/cos γ − B_xr sin α tan γ/cos β − B_yr (cos α − tan β sin α) tan γ
    /// ```
    ///
    /// where (sin α tan γ, cos α tan γ) is the horizontal part of Z_r over its vertical part. Source: DIFF
    /// eq. 5 to 11, with the sign of tan β sin α that follows from figure 1.
    pub fn eta(&self) -> Matrix3<T> {
        let [z, test @ ..] = &self.axes;
        let (sin, cos) = (self.beta.sin(), self.beta.cos());
        let tan = sin / cos;
        let (x_slope, y_slope) = (z[0] / z[2], z[1] / z[2]);
        let zero = T::from(0.0);
        let fields = [
            Vector3::new(cos.recip(), zero, -x_slope / cos),
            Vector3::new(-tan, T::from(1.0), tan * x_slope - y_slope),
            Vector3::new(zero, zero, z[2].recip()),
        ];
        let reference = [self.ratios[1], T::from(1.0), self.ratios[2]];
        let factors = self.test_factors();
        Matrix3::from_fn(|i, j| dot(&test[j], &fields[i]) * factors[j] / reference[i])
    }

    /// Cosines of the angles x·y, y·z, x·z between the reference's axes, then of those between the test's.
    pub fn cosines(&self) -> [T; 6] {
        let zero = T::from(0.0);
        let [z_r, x, y, z] = &self.axes;
        let x_r = Vector3::new(self.beta.cos(), self.beta.sin(), zero);
        let y_r = Vector3::new(zero, T::from(1.0), zero);
        [(&x_r, &y_r), (&y_r, z_r), (&x_r, z_r), (x, y), (y, z), (x, z)].map(|(a, b)| dot(a, b))
    }
}

impl Pair {
    pub fn of_parameters(parameters: &[f64; 14]) -> Self {
        Self {
            beta: parameters[BETA],
            axes: ANGLES.map(|[azimuth, polar]| axis(parameters[azimuth], parameters[polar])),
            ratios: std::array::from_fn(|k| parameters[RATIOS + k]),
        }
    }

    /// The fourteen parameters: an axis (x, y, z) has the azimuth atan2(x, y), from y towards x, and the
    /// polar angle atan2(√(x² + y²), z).
    pub fn parameters(&self) -> [f64; 14] {
        let mut values = [0.0; 14];
        values[BETA] = self.beta;
        values[RATIOS..].copy_from_slice(&self.ratios);
        for ([azimuth, polar], axis) in ANGLES.iter().zip(&self.axes) {
            values[*azimuth] = axis.x.atan2(axis.y);
            values[*polar] = axis.x.hypot(axis.y).atan2(axis.z);
        }
        values
    }

    pub fn is_finite(&self) -> bool {
        let axes = self.axes.iter().flat_map(|axis| axis.iter());
        axes.chain(&self.ratios).chain([&self.beta]).all(|value| value.is_finite())
    }
}

/// (sin φ sin θ, cos φ sin θ, cos θ) of an azimuth φ and a polar angle θ, rad.
pub(super) fn axis<T: Real>(azimuth: T, polar: T) -> Vector3<T> {
    let sin = polar.sin();
    Vector3::new(azimuth.sin() * sin, azimuth.cos() * sin, polar.cos())
}

pub(super) fn dot<T: Real>(a: &Vector3<T>, b: &Vector3<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross<T: Real>(a: &Vector3<T>, b: &Vector3<T>) -> Vector3<T> {
    Vector3::new(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
}
