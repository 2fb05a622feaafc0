//! The two instruments as smooth quantities: axes as unit vectors, which have no pole.

use nalgebra::{Matrix3, Vector3};
use physics::Real;

/// Places among the fourteen of azimuth and polar angle of the reference's z and of the test's x, y and z.
pub const ANGLES: [[usize; 2]; 4] = [[0, 2], [3, 4], [5, 6], [7, 8]];
pub const BETA: usize = 1;
/// Place of the first of the five ratios.
pub const RATIOS: usize = 9;

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
    /// Of β, Z_r and the ratios of the reference, and K_tj/K_yr times each axis of the test instrument.
    pub fn beside((beta, z, [x_y, z_y]): (T, Vector3<T>, [T; 2]), test: &[Vector3<T>; 3]) -> Self {
        let lengths = test.each_ref().map(|vector| vector.dot(vector).sqrt());
        let unit = |j: usize| test[j].map(|component| component / lengths[j]);
        let ratios = [lengths[0] / x_y, x_y, z_y, lengths[0] / lengths[1], lengths[2] / lengths[1]];
        Self { beta, axes: [z, unit(0), unit(1), unit(2)], ratios }
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
        let (zero, one) = (T::from(0.0), T::from(1.0));
        let fields = [
            Vector3::new(cos.recip(), zero, -x_slope / cos),
            Vector3::new(-tan, one, tan * x_slope - y_slope),
            Vector3::new(zero, zero, z[2].recip()),
        ];
        let [xt_xr, xr_yr, zr_yr, xt_yt, zt_yt] = self.ratios;
        let x = xt_xr * xr_yr;
        let y = x / xt_yt;
        let (reference, factors) = ([xr_yr, one, zr_yr], [x, y, y * zt_yt]);
        Matrix3::from_fn(|i, j| test[j].dot(&fields[i]) * factors[j] / reference[i])
    }

    /// Cosines of the angles x·y, y·z, x·z between the reference's axes, then of those between the test's.
    pub fn cosines(&self) -> [T; 6] {
        let zero = T::from(0.0);
        let [z_r, x, y, z] = &self.axes;
        let x_r = Vector3::new(self.beta.cos(), self.beta.sin(), zero);
        let y_r = Vector3::new(zero, T::from(1.0), zero);
        [(&x_r, &y_r), (&y_r, z_r), (&x_r, z_r), (x, y), (y, z), (x, z)].map(|(a, b)| a.dot(b))
    }
}

impl Pair {
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
