//! The two magnetometers of a differential recording, as DIFF describes them.

use common::{DifferentialCalibration, Error, Matrix3x3, Noise, PerAxis, Quantity};
use nalgebra::{Matrix3, Vector3};
use physics::frames;
use serde::{Deserialize, Serialize};

/// Axes and scales of the two magnetometers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DifferentialTruth {
    /// The reference.
    pub reference: ReferenceAxes,
    /// The test instrument.
    pub test: TestAxes,
    /// Constant part of the additive error of the test instrument, nT.
    #[serde(default)]
    pub offset_nt: [f64; 3],
    /// Noise of the reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_noise: Option<Noise>,
    /// A third instrument, read as `third_x_nt`, ….
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub third: Option<ThirdTruth>,
}

/// A third instrument beside the two.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ThirdTruth {
    /// Its axes and scales.
    pub axes: TestAxes,
    /// Constant part of its additive error, nT.
    #[serde(default)]
    pub offset_nt: [f64; 3],
    /// Its noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
}

/// The reference: x and y in the horizontal plane, y the y of the frame; angles in deg.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ReferenceAxes {
    /// α: from y to the horizontal part of z.
    #[serde(default)]
    pub alpha_deg: f64,
    /// β: from x of the frame to x of the reference.
    #[serde(default)]
    pub beta_deg: f64,
    /// γ: from the vertical to z of the reference.
    #[serde(default)]
    pub gamma_deg: f64,
    /// Reading over field of x, y, z.
    #[serde(default = "ones")]
    pub scale: [f64; 3],
}

/// The test instrument: axis j is (sin φ sin θ, cos φ sin θ, cos θ), angles in deg.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TestAxes {
    /// φ of x, y, z; nominally 90, 0, any.
    pub phi_deg: [f64; 3],
    /// θ of x, y, z; nominally 90, 90, 0.
    pub theta_deg: [f64; 3],
    /// Reading over field of x, y, z.
    #[serde(default = "ones")]
    pub scale: [f64; 3],
}

fn ones() -> [f64; 3] {
    [1.0; 3]
}

impl TestAxes {
    /// Rows = scale × axis: the readings are this times B.
    pub fn matrix(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|row, column| {
            let (phi, theta) = (self.phi_deg[row].to_radians(), self.theta_deg[row].to_radians());
            let axis = [phi.sin() * theta.sin(), phi.cos() * theta.sin(), theta.cos()];
            axis[column] * self.scale[row]
        })
    }
}

impl DifferentialTruth {
    /// M_r: rows = scale × axis of the reference; its readings are M_r B.
    pub fn reference_matrix(&self) -> Matrix3<f64> {
        let ReferenceAxes { alpha_deg, beta_deg, gamma_deg, scale } = &self.reference;
        let [alpha, beta, gamma] = [alpha_deg, beta_deg, gamma_deg].map(|angle| angle.to_radians());
        let axes = [
            Vector3::new(beta.cos(), beta.sin(), 0.0),
            Vector3::y(),
            Vector3::new(gamma.sin() * alpha.sin(), gamma.sin() * alpha.cos(), gamma.cos()),
        ];
        Matrix3::from_fn(|row, column| axes[row][column] * scale[row])
    }

    /// η and d of T = R η + d: with R = M_r B and T = M_t B (columns), ηᵀ = M_t M_r⁻¹.
    pub fn calibration(&self) -> Result<DifferentialCalibration, Error> {
        let inverse = self.reference_matrix().try_inverse().ok_or_else(|| {
            let expected = "three axes that do not lie in one plane, and scales that are not zero";
            Error::document("truth.differential.reference", "axes without an inverse", expected)
        })?;
        let eta = (self.test.matrix() * inverse).transpose();
        let [x, y, z] = self.offset_nt.map(|offset| Some(Quantity::Bare(offset)));
        let matrix: Matrix3x3 = frames::rows(&eta);
        let offset_nt = Some(PerAxis { x, y, z, ..PerAxis::default() });
        Ok(DifferentialCalibration { matrix: Some(matrix), offset_nt, ..DifferentialCalibration::default() })
    }
}
