use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{Extra, Findings, Matrix3x3, Quantity};

/// The frame from which the quaternions of star cameras turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum AttitudeFrame {
    /// North, east and down at the place, geodetic.
    #[default]
    Geo,
    /// Fixed to the Earth.
    Itrf,
    /// Celestial.
    Icrf,
}

impl AttitudeFrame {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Geo, Self::Itrf, Self::Icrf];

    /// Its name in documents.
    pub fn name(self) -> &'static str {
        match self {
            Self::Geo => "geo",
            Self::Itrf => "itrf",
            Self::Icrf => "icrf",
        }
    }

    /// The one of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|frame| frame.name() == name)
    }
}

/// A vector magnetometer beside star cameras in flight, by starcal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct FlightCalibration {
    /// Recordings of which the rows are; none of a stream.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub recordings: Vec<String>,
    /// The frame from which the attitudes turn.
    pub frame: AttitudeFrame,
    /// Where the field is from.
    pub field: String,
    /// Rows that were used.
    pub rows: u64,
    /// Windows of time by which uncertainties were found.
    pub windows: u64,
    /// Width of each, s.
    pub window_s: f64,
    /// Degrees of freedom of the intervals.
    pub degrees_of_freedom: f64,
    /// The heads of the star cameras.
    pub cameras: Vec<FlightCamera>,
    /// What was found beside the twelve parameters, the likeliest first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<FlightTerm>,
    /// Rms of the residual in quiet rows, all three directions, without these terms, nT.
    pub rms_without_terms_nt: f64,
    /// The same with them, nT.
    pub rms_nt: f64,
    /// What looks wrong, in words.
    #[serde(flatten)]
    pub findings: Findings,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The head of a star camera.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct FlightCamera {
    /// What its columns begin with.
    pub camera: String,
    /// Turns a vector from SEN to the frame of the head; rows.
    pub rotation: Matrix3x3,
    /// Angles a, b, c of that rotation Rz(c) Ry(b) Rx(a), each with its uncertainty.
    pub angles_deg: [Quantity; 3],
    /// Standard uncertainty of a turn about each axis of the head, arcsec.
    pub turn_std_arcsec: [f64; 3],
    /// The same of its turn against the first head.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against_first_std_arcsec: Option<[f64; 3]>,
    /// Rms of the residual by kind of place; of another head than the first it is that of the field as the first sees it.
    pub residuals: Vec<FlightResidual>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The residual in rows of a kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct FlightResidual {
    /// `quiet`, or `disturbed`: beyond 55° of dip latitude, or Kp above 2.
    pub place: String,
    /// Rows.
    pub rows: u64,
    /// Along the field, nT.
    pub along_nt: f64,
    /// Across the field and the boresight, nT.
    pub across_nt: f64,
    /// Across the field, in the plane of the field and the boresight, nT.
    pub towards_boresight_nt: f64,
}

/// A term beside the twelve parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct FlightTerm {
    /// What it is, in words.
    pub term: String,
    /// The effect of the catalogue, where it is one; it is in `model.effects` then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effect: Option<String>,
    /// The column that it follows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// The head that it is about, where it is about one alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<String>,
    /// Its parameters.
    pub parameters: IndexMap<String, Quantity>,
    /// ln of the Bayes factor for it.
    pub log_bayes_factor: f64,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}
