//! The parameters and their covariances.

use nalgebra::SMatrix;

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

/// What η and the five known values say.
#[derive(Clone, Debug)]
pub struct Fourteen {
    /// In the order of [`NAMES`]. α and φ lie in −π..=π, γ and θ in 0..=π.
    pub values: [f64; 14],
    /// Their covariance to first order.
    pub covariance: SMatrix<f64, 14, 14>,
    /// The azimuths (α, φ_x, φ_y, φ_z) of axes that are vertical within four standard uncertainties: their
    /// standard uncertainty is [`super::UNDETERMINED_RAD`], and they correlate with nothing.
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
