//! Pairs of instruments to find again.

use common::Magnetometer::{Reference, Test};
use diffmag::fourteen::KnownFive;
use nalgebra::{Matrix3, SMatrix, Vector3};

/// Fourteen parameters from angles in degrees (α, β, γ, then φ and θ of x, y, z) and the five ratios.
pub fn parameters(degrees: [f64; 9], ratios: [f64; 5]) -> [f64; 14] {
    std::array::from_fn(|i| if i < 9 { degrees[i].to_radians() } else { ratios[i - 9] })
}

/// (sin φ sin θ, cos φ sin θ, cos θ).
fn axis(phi: f64, theta: f64) -> Vector3<f64> {
    Vector3::new(phi.sin() * theta.sin(), phi.cos() * theta.sin(), theta.cos())
}

fn test_axes(p: &[f64; 14]) -> [Vector3<f64>; 3] {
    [axis(p[3], p[4]), axis(p[5], p[6]), axis(p[7], p[8])]
}

/// η = M_r⁻ᵀ M_tᵀ of fourteen parameters, rows of M the axes times K.
pub fn eta_of(p: &[f64; 14]) -> Matrix3<f64> {
    let [xt_xr, xr_yr, zr_yr, xt_yt, zt_yt] = [p[9], p[10], p[11], p[12], p[13]];
    let (xt, [x, y, z]) = (xt_xr * xr_yr, test_axes(p));
    let x_r = Vector3::new(p[1].cos(), p[1].sin(), 0.0);
    let reference = Matrix3::from_columns(&[x_r * xr_yr, Vector3::y(), axis(p[0], p[2]) * zr_yr]);
    let test = Matrix3::from_columns(&[x * xt, y * (xt / xt_yt), z * (xt / xt_yt * zt_yt)]);
    reference.try_inverse().expect("three axes") * test
}

/// The five of the reference and of the test instrument, without uncertainty.
pub fn known(p: &[f64; 14]) -> [KnownFive; 2] {
    let ([alpha, beta, gamma], [x, y, z]) = ([p[0], p[1], p[2]], test_axes(p));
    let tilts = [gamma.sin() * alpha.sin(), gamma.sin() * alpha.cos(), beta, p[10], p[11]];
    let cosines = [x.dot(&y), y.dot(&z), x.dot(&z), p[12], p[13]];
    [(Reference, tilts), (Test, cosines)].map(|(instrument, values)| KnownFive {
        instrument,
        values,
        covariance: SMatrix::zeros(),
    })
}
