//! What is known of one of the instruments.

use common::Magnetometer;
use common::number::significant;
use nalgebra::{DMatrix, Matrix3, SMatrix};
use std::f64::consts::FRAC_PI_2;

use crate::Error;

/// Where a document has the five.
pub const PATH: &str = "calibration.differential.known";
/// Cosines of β and γ and eigenvalues of the cosine matrix below this belong to axes that lie in a plane.
const FLAT: f64 = 1e-6;
/// Negative eigenvalues of a correlation matrix down to here, and unequal halves, are rounding.
const ROUNDING: f64 = 1e-8;

/// The five values that are known of one of the instruments.
#[derive(Clone, Debug)]
pub struct KnownFive {
    /// Which instrument.
    pub instrument: Magnetometer,
    /// Three numbers that say how its axes stand, then K_x/K_y and K_z/K_y.
    ///
    /// Of the reference: sin γ sin α and sin γ cos α, the horizontal part of Z_r along x and y, with cos γ > 0;
    /// and β, rad. Of the test instrument: the cosines of the angles between its axes, x·y, y·z, x·z. Each is
    /// sin ε of the pair's departure ε from a right angle, positive where the axes lean towards each other, as
    /// sin ε_xy = sin β, sin ε_yz = sin γ cos α and sin ε_xz = sin γ sin(α + β) are for the reference.
    pub values: [f64; 5],
    /// Their covariance.
    pub covariance: SMatrix<f64, 5, 5>,
}

impl KnownFive {
    /// Refuses values that no instrument has.
    pub(super) fn check(&self) -> Result<(), Error> {
        let refuse = |found: String, expected: &str| Err(Error::document(PATH, found, expected));
        if self.values.iter().any(|value| !value.is_finite()) {
            return refuse(format!("{:?}", self.values), "five finite numbers");
        }
        let [a, b, c, x_y, z_y] = self.values;
        if let Some(ratio) = [x_y, z_y].into_iter().find(|ratio| *ratio <= 0.0) {
            let expected =
                "ratios of K greater than zero (a sensor that is mounted backwards has its axis turned)";
            return refuse(format!("a ratio of {ratio}"), expected);
        }
        match self.instrument {
            Magnetometer::Reference if a.hypot(b) > 1.0 - FLAT || c.abs() > FRAC_PI_2 - FLAT => {
                let expected = "sin γ sin α and sin γ cos α of an axis less than 90° from z, and β in rad";
                return refuse(format!("tilts {a} and {b}, β = {c}"), expected);
            }
            Magnetometer::Reference => {}
            Magnetometer::Test => {
                let smallest = Matrix3::new(1.0, a, c, a, 1.0, b, c, b, 1.0).symmetric_eigenvalues().min();
                if smallest < FLAT {
                    let found = format!(
                        "cosines {a}, {b} and {c}, whose matrix has an eigenvalue of {} (it must be positive definite)",
                        significant(smallest, 3)
                    );
                    let expected =
                        "cosines between three axes that do not lie in a plane (0 for right angles)";
                    return refuse(found, expected);
                }
            }
        }
        check_covariance(&self.covariance, "the known values")
    }
}

/// Refuses a matrix that is no covariance: looked at as a correlation, so that units do not matter.
pub(super) fn check_covariance<const N: usize>(
    covariance: &SMatrix<f64, N, N>,
    of: &str,
) -> Result<(), Error> {
    let refuse = |found: String| {
        Err(Error::Unanswerable(format!(
            "the covariance of {of} is invalid: {found}; it must be finite, symmetric and have no negative eigenvalue"
        )))
    };
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
