use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{Extra, Quantity};

/// One of two magnetometers side by side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Magnetometer {
    /// The one that is trusted.
    #[default]
    Reference,
    /// The one under test.
    Test,
}

/// Five values of one of two magnetometers that are known beforehand; those that are absent are 0 and 1, and
/// exact.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct KnownInstrument {
    /// Whose they are.
    pub instrument: Magnetometer,
    /// 90° less the angle between two of its axes, arcsec, keyed `xy`, `yz`, `xz`.
    pub non_orthogonality_arcsec: IndexMap<String, Quantity>,
    /// Reading of x per nT over that of y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio_x_y: Option<Quantity>,
    /// Reading of z per nT over that of y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio_z_y: Option<Quantity>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The fourteen parameters of two magnetometers side by side (DIFF), of which five are known.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct FourteenParameters {
    /// Whose five were known.
    pub known: Magnetometer,
    /// Nobody stated them: that instrument was taken as orthogonal, with equal scales.
    pub assumed: bool,
    /// α, β, γ of the reference, φ and θ of each axis of the test instrument.
    pub angles: IndexMap<String, Angle>,
    /// Ratios of scale factors (reading per nT): `xt_xr` is that of the test's x to the reference's x.
    pub ratios: IndexMap<String, Quantity>,
    /// Azimuths that mean nothing, because their axis is vertical within its uncertainty.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub undetermined: Vec<String>,
    /// 90° less the angle between two axes of the reference, arcsec, keyed `xy`, `yz`, `xz`.
    pub reference_non_orthogonality_arcsec: IndexMap<String, Quantity>,
    /// The same of the test instrument.
    pub test_non_orthogonality_arcsec: IndexMap<String, Quantity>,
    /// Largest difference between the closed form and the numerical solution, rad.
    pub numerical_difference_rad: f64,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// An angle as people read it and as calibrations state it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Angle {
    /// The angle, deg.
    pub value_deg: f64,
    /// Its standard uncertainty, arcsec.
    pub std_arcsec: f64,
    /// From the direction that it has when the instruments stand as meant (0° or 90°), arcsec. Absent for
    /// azimuths of axes that are meant to be vertical.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub off_nominal_arcsec: Option<f64>,
}
