use serde::{Deserialize, Serialize};

use crate::quantity::not_negative;
use crate::{Extra, Noise, PerAxis, Quantity};

/// The coil facility as its makers state it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Facility {
    /// The coils by axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coils: Option<PerAxis<Coil>>,
    /// The voltmeter that reads the precision resistors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub voltmeter: Option<Voltmeter>,
    /// Standard uncertainty of one theodolite reading, arcsec. Absent: orientations are taken as exact.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub theodolite_arcsec: Option<f64>,
    /// Standard uncertainty of what all theodolite readings of one angle in one setting of the block have in
    /// common (levelling, pointing at the face), arcsec: it stays however often the angle is read. Absent: 0.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub theodolite_shared_arcsec: Option<f64>,
    /// Standard uncertainty of the scalar reference, nT.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub reference_std_nt: Option<f64>,
    /// Smallest and largest field that the scalar reference reads, nT; absent: 20 000 to 60 000, a proton
    /// magnetometer's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_range_nt: Option<[f64; 2]>,
    /// Standard uncertainty of each component of the field that nulling leaves, nT (GEO).
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub residual_field_std_nt: Option<f64>,
    /// Noise of each component of the field in the coils, beside that of the instrument: what a reading there
    /// scatters by besides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<Noise>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Facility {
    /// Standard uncertainty of the mean of so many theodolite readings of an angle, arcsec: √(shared² +
    /// reading²/n); None where neither is stated.
    pub fn theodolite_std_arcsec(&self, readings: usize) -> Option<f64> {
        let shared = self.theodolite_shared_arcsec;
        let own = self.theodolite_arcsec.map(|std| std / (readings.max(1) as f64).sqrt());
        own.or(shared).map(|_| own.unwrap_or(0.0).hypot(shared.unwrap_or(0.0)))
    }
}

/// One coil with its precision resistor.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Coil {
    /// Resistance of the precision resistor in series, ohm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resistor_ohm: Option<f64>,
    /// Relative standard uncertainty of that resistance.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub resistor_relative_uncertainty: Option<f64>,
    /// Largest field that the coil makes, nT.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_nt: Option<f64>,
    /// How its field changes along its axis at the centre, for each ampere, nT/(m A).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradient_nt_per_m_a: Option<Quantity>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The voltmeter's uncertainty: an absolute and a relative part.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Voltmeter {
    /// Absolute standard uncertainty, V.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub absolute_v: Option<f64>,
    /// Relative standard uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "not_negative")]
    #[cfg_attr(feature = "schema", schemars(range(min = 0.0)))]
    pub relative: Option<f64>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}
