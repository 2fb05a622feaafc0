use common::number::{figures, significant};
use nalgebra::{DMatrix, Matrix3, SMatrix};
use std::f64::consts::{FRAC_PI_2, TAU};

use super::error::Error;

/// Cosines of β and γ and eigenvalues of the cosine matrix below this belong to axes that lie in a plane.
const FLAT: f64 = 1e-6;
/// An azimuth no better than this is beyond propagation to first order, rad: its axis is within four of its
/// standard uncertainties of the vertical.
pub(super) const LOOSE_RAD: f64 = 0.25;
/// Negative eigenvalues of a correlation matrix down to here, and unequal halves, are rounding.
const ROUNDING: f64 = 1e-8;

/// The three numbers that say how the axes of the known instrument stand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KnownAxes {
    /// Of the reference: α, β, γ, rad. Where γ is zero within its uncertainty α means nothing, and the
    /// propagation to first order through it is wrong: use [`KnownAxes::ReferenceTilts`].
    Reference([f64; 3]),
    /// Of the reference: sin γ sin α, sin γ cos α and β (rad), with cos γ > 0. The first two are the
    /// horizontal part of Z_r along x and y.
    ReferenceTilts([f64; 3]),
    /// Of the test instrument: the cosines of the angles between its own axes, x·y, y·z, x·z. Each is sin ε
    /// of the pair's departure ε from a right angle, positive where the axes lean towards each other (less
    /// than 90°), as sin ε_xy = sin β, sin ε_yz = sin γ cos α and sin ε_xz = sin γ sin(α + β) are for the
    /// reference.
    Test([f64; 3]),
}

impl KnownAxes {
    /// The three numbers.
    fn values(&self) -> [f64; 3] {
        match *self {
            KnownAxes::Reference(values) | KnownAxes::ReferenceTilts(values) | KnownAxes::Test(values) => {
                values
            }
        }
    }
}

/// The five values that are known of one of the instruments.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownFive {
    /// How the axes of that instrument stand.
    pub axes: KnownAxes,
    /// K_x/K_y and K_z/K_y of the same instrument.
    pub ratios: [f64; 2],
    /// Covariance of the five: the three of `axes`, then the two of `ratios`.
    pub covariance: SMatrix<f64, 5, 5>,
}

impl KnownFive {
    /// The five values in the order of the covariance.
    pub(super) fn values(&self) -> [f64; 5] {
        let ([a, b, c], [d, e]) = (self.axes.values(), self.ratios);
        [a, b, c, d, e]
    }

    /// Refuses values that no instrument has.
    pub(super) fn check(&self) -> Result<(), Error> {
        let (instrument, expected) = match self.axes {
            KnownAxes::Reference(_) => {
                ("reference", "α, β and γ in rad, within one turn, of axes that do not lie in a plane")
            }
            KnownAxes::ReferenceTilts(_) => {
                ("reference", "sin γ sin α and sin γ cos α of an axis less than 90° from z, and β in rad")
            }
            KnownAxes::Test(_) => (
                "test instrument",
                "cosines between three axes that do not lie in a plane (0 for right angles)",
            ),
        };
        let refuse = |found: String, expected| Err(Error::Known { instrument, found, expected });
        if self.values().iter().any(|value| !value.is_finite()) {
            return refuse(format!("{:?}", self.values()), "five finite numbers");
        }
        if let Some(ratio) = self.ratios.iter().find(|ratio| **ratio <= 0.0) {
            let expected =
                "ratios of K greater than zero (a sensor that is mounted backwards has its axis turned)";
            return refuse(format!("a ratio of {ratio}"), expected);
        }
        let [a, b, c] = self.axes.values();
        match self.axes {
            KnownAxes::Reference(angles) => {
                if angles.iter().any(|angle| angle.abs() > TAU) || b.cos().abs().min(c.cos().abs()) < FLAT {
                    return refuse(format!("α = {a}, β = {b}, γ = {c}"), expected);
                }
                let loose = self.covariance[(0, 0)].sqrt();
                if loose > LOOSE_RAD {
                    let expected = "α known to better than 0.25 rad; otherwise sin γ sin α and sin γ cos α in place of α and γ";
                    return refuse(format!("α with an uncertainty of {} rad", figures(loose, 2)), expected);
                }
            }
            KnownAxes::ReferenceTilts(_) => {
                if a.hypot(b) > 1.0 - FLAT || c.abs() > FRAC_PI_2 - FLAT {
                    return refuse(format!("tilts {a} and {b}, β = {c}"), expected);
                }
            }
            KnownAxes::Test(_) => {
                let smallest = cosine_matrix([a, b, c]).symmetric_eigenvalues().min();
                if smallest < FLAT {
                    return refuse(
                        format!(
                            "cosines {a}, {b} and {c}, whose matrix has an eigenvalue of {} (it must be positive definite)",
                            significant(smallest, 3)
                        ),
                        expected,
                    );
                }
            }
        }
        check_covariance(&self.covariance, "the known values")
    }
}

/// The matrix of cosines between three axes, from x·y, y·z, x·z.
fn cosine_matrix([xy, yz, xz]: [f64; 3]) -> Matrix3<f64> {
    Matrix3::new(1.0, xy, xz, xy, 1.0, yz, xz, yz, 1.0)
}

/// Refuses a matrix that is no covariance: looked at as a correlation, so that units do not matter.
pub(super) fn check_covariance<const N: usize>(
    covariance: &SMatrix<f64, N, N>,
    of: &'static str,
) -> Result<(), Error> {
    let refuse = |found: String| Err(Error::Covariance { of, found });
    if covariance.iter().any(|element| !element.is_finite()) {
        return refuse("an element is not finite".into());
    }
    if let Some(i) = (0..N).find(|&i| covariance[(i, i)] < 0.0) {
        return refuse(format!("variance {} is {}", i + 1, significant(covariance[(i, i)], 3)));
    }
    // Floor of the smallest number keeps a variance of zero from dividing by it.
    let scale = |i: usize| covariance[(i, i)].sqrt().max(f64::MIN_POSITIVE);
    let correlation = DMatrix::from_fn(N, N, |i, j| covariance[(i, j)] / scale(i) / scale(j));
    if correlation.iter().any(|element| element.is_nan() || element.abs() > 1.0 + ROUNDING) {
        return refuse("a covariance is larger than its variances allow".into());
    }
    if (&correlation - correlation.transpose()).amax() > ROUNDING {
        return refuse("it is not symmetric".into());
    }
    let smallest = correlation.symmetric_eigenvalues().min();
    if smallest < -ROUNDING {
        return refuse(format!("its correlations have an eigenvalue of {}", significant(smallest, 3)));
    }
    Ok(())
}
