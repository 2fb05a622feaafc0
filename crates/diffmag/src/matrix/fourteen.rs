//! The fourteen parameters of two magnetometers in one field, from η of T = R η + d and five of them that are
//! known.
//!
//! Frame: x and y horizontal, y along the reference's y; z the third axis, right-handed. Rows are axes:
//!
//! ```text
//! X_r = (cos β, sin β, 0)    Y_r = (0, 1, 0)    Z_r = (sin γ sin α, sin γ cos α, cos γ)
//! test axis j = (sin φ_j sin θ_j, cos φ_j sin θ_j, cos θ_j)
//! R = B M_rᵀ    T = B M_tᵀ    M = diag(K) · axes    η = M_r⁻ᵀ M_tᵀ
//! ```
//!
//! K is reading per nT of an axis and positive: a sensor mounted backwards has the axis turned, not K < 0.
//! Nine elements of η are functions of fourteen parameters, so five must be known of one of the instruments
//! (DIFF, "linear regression method", last paragraph). Closed form where the source solves nine equations
//! numerically; [`solve_numerically`] is the source's route. DIFF's eq. 4 and 5 have signs that do not agree
//! with its figure 1; the axes above are the figure's. Its fourteenth parameter is K_yt/K_yr (eq. 10); here
//! it is K_xt/K_xr = (K_yt/K_yr) (K_xt/K_yt)/(K_xr/K_yr).

mod closed;
mod covariance;
mod known;
mod numeric;
mod pair;

pub use covariance::UNDETERMINED_RAD;
pub use known::KnownFive;
pub(crate) use known::PATH as KNOWN_PATH;
pub use numeric::solve_numerically;

use common::number::uncertain;
use nalgebra::{Matrix3, SMatrix, SVector};

use crate::Error;

/// Covariance of η, elements column after column: η_xx, η_yx, η_zx, η_xy, … (first letter the reference's
/// axis, second the test's), each in the square of K_t/K_r.
pub type EtaCovariance = SMatrix<f64, 9, 9>;

/// The parameters by name, in the order of every array of fourteen: angles in rad, ratios of K without unit.
pub const NAMES: [&str; 14] = [
    "alpha_rad",
    "beta_rad",
    "gamma_rad",
    "phi_x_rad",
    "theta_x_rad",
    "phi_y_rad",
    "theta_y_rad",
    "phi_z_rad",
    "theta_z_rad",
    "ratio_xt_xr",
    "ratio_xr_yr",
    "ratio_zr_yr",
    "ratio_xt_yt",
    "ratio_zt_yt",
];

/// Singular values of η with columns of unit length that are smaller than this share of the largest count as
/// zero.
const FLAT: f64 = 1e-9;
/// Standard uncertainties by which the determinant of η must differ from zero.
const SIGMAS: f64 = 3.0;

/// What η and the five known values say.
#[derive(Clone, Debug)]
pub struct Fourteen {
    /// In the order of [`NAMES`]. α and φ lie in −π..=π, γ and θ in 0..=π.
    pub values: [f64; 14],
    /// Their covariance to first order.
    pub covariance: SMatrix<f64, 14, 14>,
    /// The azimuths (α, φ_x, φ_y, φ_z) of axes that are vertical within four standard uncertainties: their
    /// standard uncertainty is [`UNDETERMINED_RAD`], and they correlate with nothing.
    pub undetermined: Vec<&'static str>,
    /// Cosines of the angles between axes: x·y, y·z, x·z of the reference, then of the test instrument.
    pub cosines: [f64; 6],
    /// Their standard uncertainties.
    pub cosine_uncertainties: [f64; 6],
}

impl Fourteen {
    /// Standard uncertainties of the values.
    pub fn uncertainties(&self) -> [f64; 14] {
        std::array::from_fn(|i| self.covariance[(i, i)].sqrt())
    }
}

/// The fourteen parameters in closed form, and their covariance by first-order propagation with exact
/// derivatives.
///
/// With the reference known, the rows of ηᵀ M_r are K_tj × test axis j: lengths give factors, directions give
/// angles. With the test instrument known, M_r M_rᵀ = η⁻ᵀ (M_t M_tᵀ) η⁻¹ gives the reference first; M_t M_tᵀ
/// needs only the five. That product does not say on which side of the horizontal plane Z_r lies, nor on
/// which side of y X_r does: cos β > 0 and cos γ > 0 are taken, a right-handed reference whose x and z look
/// along those of the frame. η and the known values err independently. Source: DIFF eq. 6 to 14.
pub fn solve(eta: &Matrix3<f64>, covariance: &EtaCovariance, known: &KnownFive) -> Result<Fourteen, Error> {
    known.check()?;
    known::check_covariance(covariance, "η")?;
    refuse_singular(eta, covariance)?;
    let pair = closed::solve(eta, known.instrument, &known.values);
    if !pair.is_finite() {
        return Err(no_answer());
    }
    Ok(covariance::propagate(&pair, eta, covariance, known))
}

/// η and the known values contradict each other.
fn no_answer() -> Error {
    Error::Unanswerable(
        "no pair of instruments has this η and these known values: the axes of the reference would be coplanar"
            .into(),
    )
}

/// Refuses an η that cannot be told from a singular one: det η = Σ_j η_ij C_ij, with C its cofactors, and to
/// first order var(det η) = cᵀ Σ c with c the nine cofactors.
fn refuse_singular(eta: &Matrix3<f64>, covariance: &EtaCovariance) -> Result<(), Error> {
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
