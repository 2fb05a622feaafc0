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
mod error;
mod known;
mod numeric;
mod pair;

pub use covariance::UNDETERMINED_RAD;
pub use error::Error;
pub use known::{KnownAxes, KnownFive};
pub use numeric::solve_numerically;

use nalgebra::{Matrix2, Matrix3, SMatrix, Vector2};
use pair::Pair;

/// Covariance of η, elements column after column: η_xx, η_yx, η_zx, η_xy, … (first letter the reference's
/// axis, second the test's), each in the square of K_t/K_r.
pub type EtaCovariance = SMatrix<f64, 9, 9>;

/// Covariance of the fourteen parameters.
pub type FourteenCovariance = SMatrix<f64, 14, 14>;

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

/// Places among the fourteen of azimuth and polar angle of the reference's z and of the test's x, y and z.
const ANGLES: [[usize; 2]; 4] = [[0, 2], [3, 4], [5, 6], [7, 8]];
/// Place of β.
const BETA: usize = 1;
/// Place of the first of the five ratios.
const RATIOS: usize = 9;

/// The horizontal part of an axis that is nominally vertical: well defined where its azimuth is not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tilt {
    /// Along x (sin γ sin α, or sin θ sin φ) and along y (sin γ cos α, or sin θ cos φ): rad where small.
    pub value: Vector2<f64>,
    /// Its covariance.
    pub covariance: Matrix2<f64>,
}

/// What η and the five known values say.
#[derive(Clone, Debug, PartialEq)]
pub struct Fourteen {
    /// In the order of [`NAMES`]. α and φ lie in −π..=π, γ and θ in 0..=π; a known value stays as it was
    /// given.
    pub values: [f64; 14],
    /// Their covariance to first order.
    pub covariance: FourteenCovariance,
    /// The azimuths (α, φ_x, φ_y, φ_z) that are not determined, because the axis is vertical within four
    /// standard uncertainties: their standard uncertainty is [`UNDETERMINED_RAD`], and they correlate with
    /// nothing.
    pub undetermined: Vec<&'static str>,
    /// The tilt of the reference's z.
    pub reference_tilt: Tilt,
    /// The tilt of the test's z.
    pub test_tilt: Tilt,
    /// Cosines of the angles between axes: x·y, y·z, x·z of the reference, then of the test instrument.
    pub cosines: [f64; 6],
    /// Their standard uncertainties.
    pub cosine_uncertainties: [f64; 6],
}

impl Fourteen {
    /// Names of the values, in their order.
    pub fn names() -> &'static [&'static str; 14] {
        &NAMES
    }

    /// Standard uncertainties of the values: roots of the covariance's diagonal.
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
    error::refuse_singular(eta, covariance)?;
    let pair = closed::solve(eta, known);
    if !pair.is_finite() {
        return Err(Error::NoAnswer);
    }
    Ok(covariance::propagate(&pair, eta, covariance, known))
}

/// η = M_r⁻ᵀ M_tᵀ of fourteen parameters in the order of [`NAMES`]: the forward model. Row i belongs to the
/// reference's axis i, column j to the test's axis j; an element is K_tj/K_ri times a number made of cosines.
pub fn eta_of(parameters: &[f64; 14]) -> Matrix3<f64> {
    Pair::of_parameters(parameters).eta()
}
