//! Pairs of instruments to find again.

use diffmag::fourteen::{KnownAxes, KnownFive};
use nalgebra::{SMatrix, Vector3};

/// Fourteen parameters from angles in degrees (α, β, γ, then φ and θ of x, y, z) and the five ratios.
pub fn parameters(degrees: [f64; 9], ratios: [f64; 5]) -> [f64; 14] {
    std::array::from_fn(|i| if i < 9 { degrees[i].to_radians() } else { ratios[i - 9] })
}

/// The test's axes.
pub fn test_axes(p: &[f64; 14]) -> [Vector3<f64>; 3] {
    std::array::from_fn(|j| {
        let (phi, theta) = (p[3 + 2 * j], p[4 + 2 * j]);
        Vector3::new(phi.sin() * theta.sin(), phi.cos() * theta.sin(), theta.cos())
    })
}

/// The five of the reference, without uncertainty.
pub fn reference(p: &[f64; 14]) -> KnownFive {
    KnownFive {
        axes: KnownAxes::Reference([p[0], p[1], p[2]]),
        ratios: [p[10], p[11]],
        covariance: SMatrix::zeros(),
    }
}

/// The same by tilts.
pub fn tilts(p: &[f64; 14]) -> KnownFive {
    let axes = KnownAxes::ReferenceTilts([p[2].sin() * p[0].sin(), p[2].sin() * p[0].cos(), p[1]]);
    KnownFive { axes, ..reference(p) }
}

/// The test instrument's own five, without uncertainty.
pub fn test(p: &[f64; 14]) -> KnownFive {
    let [x, y, z] = test_axes(p);
    let axes = KnownAxes::Test([x.dot(&y), y.dot(&z), x.dot(&z)]);
    KnownFive { axes, ratios: [p[12], p[13]], covariance: SMatrix::zeros() }
}
