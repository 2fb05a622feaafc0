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
mod parameters;
mod singular;

pub use covariance::UNDETERMINED_RAD;
pub use known::KnownFive;
pub(crate) use known::PATH as KNOWN_PATH;
pub use numeric::solve_numerically;
pub use parameters::{EtaCovariance, Fourteen, NAMES};

use nalgebra::Matrix3;

use crate::Error;

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
    singular::refuse_singular(eta, covariance)?;
    let pair = closed::solve(eta, known.instrument, &known.values);
    if !pair.is_finite() {
        return Err(singular::no_answer());
    }
    Ok(covariance::propagate(&pair, eta, covariance, known))
}
