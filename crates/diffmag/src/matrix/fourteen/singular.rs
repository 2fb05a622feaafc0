//! An η of which the fourteen do not follow.

use common::number::uncertain;
use nalgebra::{Matrix3, SVector};

use super::parameters::EtaCovariance;
use crate::Error;

/// Singular values of η with columns of unit length that are smaller than this share of the largest count as
/// zero.
const FLAT: f64 = 1e-9;
/// Standard uncertainties by which the determinant of η must differ from zero.
const SIGMAS: f64 = 3.0;

/// η and the known values contradict each other.
pub fn no_answer() -> Error {
    Error::Unanswerable(
        "no pair of instruments has this η and these known values: the axes of the reference would be coplanar"
            .into(),
    )
}

/// Refuses an η that cannot be told from a singular one: det η = Σ_j η_ij C_ij, with C its cofactors, and to
/// first order var(det η) = cᵀ Σ c with c the nine cofactors.
pub fn refuse_singular(eta: &Matrix3<f64>, covariance: &EtaCovariance) -> Result<(), Error> {
    let columns: [_; 3] = std::array::from_fn(|j| eta.column(j).into_owned());
    let cofactors = Matrix3::from_fn(|i, j| columns[(j + 1) % 3].cross(&columns[(j + 2) % 3])[i]);
    let determinant = eta.determinant();
    let gradient = SVector::<f64, 9>::from_column_slice(cofactors.as_slice());
    let uncertainty = gradient.dot(&(covariance * gradient)).max(0.0).sqrt();
    let unit = Matrix3::from_columns(&columns.map(|column| column / column.norm()));
    // Columns of zeros and elements that are not finite leave numbers here that are not finite.
    let flat = !unit.iter().all(|element| element.is_finite()) || {
        let sigma = unit.singular_values();
        sigma.min() <= FLAT * sigma.max()
    };
    if flat || determinant.abs() <= SIGMAS * uncertainty {
        return Err(Error::Unanswerable(format!(
            "η is singular within its uncertainty: its determinant is {}; three axes of one instrument are coplanar, an output is dead or connected twice, or the field did not vary in three directions",
            uncertain(determinant, uncertainty)
        )));
    }
    Ok(())
}
