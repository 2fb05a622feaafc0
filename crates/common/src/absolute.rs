use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{Extra, Findings, Quantity};

/// Absolute measurements of an observatory and the baselines of its variometer, by absolute.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AbsoluteCalibration {
    /// What the sensors of the variometer are along: `hez` or `xyz`; absent without a variometer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub components: Option<String>,
    /// Recordings of the variometer that were used.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub variometer: Vec<String>,
    /// Standard uncertainty of one circle reading with its setting, arcsec.
    pub circle_arcsec: f64,
    /// Its degrees of freedom, where the readings tell it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degrees_of_freedom: Option<f64>,
    /// The measurements, in the order of time.
    pub sets: Vec<AbsoluteSet>,
    /// The baselines that are adopted between them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adopted: Option<AdoptedBaselines>,
    /// What looks wrong, in words.
    #[serde(flatten)]
    pub findings: Findings,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// One measurement of the field with a theodolite.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AbsoluteSet {
    /// The recording.
    pub recording: String,
    /// The mean time of its readings, RFC 3339, at which the field below holds.
    pub time: String,
    /// Declination D, east of geographic north.
    pub declination_deg: Quantity,
    /// Inclination I, downwards.
    pub inclination_deg: Quantity,
    /// Magnitude F at the theodolite.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub f_nt: Option<Quantity>,
    /// Horizontal intensity H.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub h_nt: Option<Quantity>,
    /// North.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub x_nt: Option<Quantity>,
    /// East.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub y_nt: Option<Quantity>,
    /// Down.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z_nt: Option<Quantity>,
    /// Observed baseline values, by component: `h_nt`, `d_deg` and `z_nt`, or `x_nt`, `y_nt` and `z_nt`. The scatter of the
    /// measurements about the adopted baseline (`scatter_std`) is in their uncertainty.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub baseline: IndexMap<String, Quantity>,
    /// Covariance of these, in their order and units, by the readings and the scatter: without what is common to all
    /// measurements, the azimuth of the mark and the difference of the pillars.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covariance: Option<[[f64; 3]; 3]>,
    /// What the theodolite's magnetometer reads in no field.
    pub sensor_offset_nt: Quantity,
    /// Angle of its axis to the telescope's, towards rising azimuth.
    pub horizontal_collimation_arcsec: Quantity,
    /// The same towards rising zenith angle.
    pub vertical_collimation_arcsec: Quantity,
    /// The telescope's own horizontal collimation, by the mark.
    pub mark_collimation_arcsec: Quantity,
    /// What the circle reads towards geographic north.
    pub circle_north_deg: f64,
    /// χ² of the residuals.
    pub chi_squared: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: f64,
    /// The readings.
    pub readings: Vec<AbsoluteReading>,
    /// What looks wrong, in words.
    #[serde(flatten)]
    pub findings: Findings,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// One reading of a circle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AbsoluteReading {
    /// Row of the recording, from 0.
    pub row: usize,
    /// `mark up`, `east down`, `north up`, …: the view, and where the magnetometer is.
    pub position: String,
    /// The circle less what it should read, arcsec.
    pub residual_arcsec: f64,
    /// The same from the other readings alone.
    pub leave_one_out_arcsec: f64,
    /// Studentised residual.
    pub t: f64,
}

/// Baselines as functions of time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AdoptedBaselines {
    /// When `time_s` is zero, RFC 3339.
    pub start: String,
    /// Nodes, straight lines between them; at a step the time stands twice.
    pub time_s: Vec<f64>,
    /// Each component with its unit, as in the measurements.
    pub components: IndexMap<String, AdoptedBaseline>,
    /// Standard uncertainty that all values share, by component: the azimuth of the mark, the difference of the
    /// pillars. It is in `std`.
    pub common_std: IndexMap<String, f64>,
    /// F at the theodolite less F where the scalar magnetometer is, as the measurements state it, nT.
    pub pillar_difference_nt: f64,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl AdoptedBaselines {
    /// Value and standard uncertainty of a component at a time since `start`, without the columns that it depends on;
    /// at a step the value after it. None outside the nodes, and of a component that is not there.
    pub fn at(&self, component: &str, time_s: f64) -> Option<[f64; 2]> {
        let component = self.components.get(component)?;
        let next = self.time_s.partition_point(|node| *node <= time_s);
        let next = if self.time_s.last() == Some(&time_s) { next - 1 } else { next };
        let before = next.checked_sub(1)?;
        let (from, to) = (*self.time_s.get(before)?, *self.time_s.get(next)?);
        let share = if to > from { (time_s - from) / (to - from) } else { 0.0 };
        let on = |all: &[f64]| Some(all.get(before)? + share * (all.get(next)? - all.get(before)?));
        Some([on(&component.value)?, on(&component.std)?])
    }
}

/// The baseline of one component.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AdoptedBaseline {
    /// At each node.
    pub value: Vec<f64>,
    /// Standard uncertainty at each node.
    pub std: Vec<f64>,
    /// The trend of most evidence: `constant`, `line`, `parabola`, `cubic` or `spline`, each beside a random walk.
    pub trend: String,
    /// Probability of each trend.
    pub probabilities: IndexMap<String, f64>,
    /// Steps, where there are some.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<BaselineStep>,
    /// What it follows beside the time: columns of the variometer's recording.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub follows: Vec<BaselineFollows>,
    /// Scatter of the measurements about it beyond their own uncertainty.
    pub scatter_std: f64,
    /// Rms of the leave-one-out residuals, of the trend of most evidence.
    pub left_out_rms: f64,
    /// Recordings of measurements that are not used for it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_used: Vec<String>,
}

/// A step of a baseline.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct BaselineStep {
    /// Between this measurement …
    pub after: String,
    /// … and this.
    pub before: String,
    /// When it is taken to be, RFC 3339: midway.
    pub time: String,
    /// Its size.
    pub size: Quantity,
    /// Natural logarithm of the Bayes factor for it.
    pub log_bayes_factor: f64,
}

/// A baseline that follows a column: coefficient × (column − reference).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct BaselineFollows {
    /// The column.
    pub column: String,
    /// Change for one unit of the column.
    pub coefficient: Quantity,
    /// Where it adds nothing.
    pub reference: f64,
    /// Natural logarithm of the Bayes factor for it.
    pub log_bayes_factor: f64,
}
