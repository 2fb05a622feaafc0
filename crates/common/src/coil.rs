use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::{Extra, Findings, Quantity};

/// How a coil's constant was found, by coilcal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct CoilFit {
    /// The recordings.
    pub recordings: Vec<String>,
    /// Readings used.
    pub readings: usize,
    /// Levels of drive.
    pub levels: usize,
    /// `line`, or the departure that was fitted beside it.
    pub model: String,
    /// Standard uncertainties from scatter (type A) and from resistor and voltmeter (type B), by key.
    pub uncertainty: IndexMap<String, Budget>,
    /// Rms of the residuals, nT.
    pub rms_nt: f64,
    /// Scatter of the repeats about their levels, nT; absent without repeats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pure_error_nt: Option<f64>,
    /// Standard deviation of one reading that the type A uncertainties rest on, nT.
    pub noise_nt: f64,
    /// Where that comes from: `residuals`, `levels` (they scatter more than the repeats), `declared`.
    pub noise_source: String,
    /// Of that standard deviation.
    pub degrees_of_freedom: f64,
    /// From standard uncertainty to 95 % interval.
    pub coverage_factor_95: f64,
    /// Lack of fit of the model that is reported, against the repeats; absent without repeats.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lack_of_fit: Option<FTest>,
    /// Probability of such an offset if there were none.
    pub offset_p: f64,
    /// Departures that would have explained the readings about as well as the one that is fitted.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rivals: Vec<String>,
    /// What was looked for beside the line.
    pub departures: Vec<Departure>,
    /// The levels.
    pub residuals: CoilResiduals,
    /// What looks wrong, in words.
    #[serde(flatten)]
    pub findings: Findings,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The two parts of a standard uncertainty (JCGM 100).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Budget {
    /// From scatter; averages down.
    pub type_a: f64,
    /// From resistor and voltmeter, common to all points; does not average down.
    pub type_b: f64,
}

/// An F test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FTest {
    /// The ratio.
    pub f: f64,
    /// Degrees of freedom above.
    pub above: f64,
    /// Degrees of freedom below.
    pub below: f64,
    /// Probability of a larger ratio by chance.
    pub p_value: f64,
}

/// One departure from the line.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Departure {
    /// Its name.
    pub departure: String,
    /// Its size; the unit stands in the key.
    pub parameter: IndexMap<String, Quantity>,
    /// Probability of such a size by chance.
    pub p_value: f64,
    /// The same for the largest of all that were looked for.
    pub p_adjusted: f64,
    /// Whether it is claimed.
    pub found: bool,
}

/// The levels of drive as columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct CoilResiduals {
    /// Current, A.
    pub drive_a: Vec<f64>,
    /// Mean field, with the sign of the drive, nT.
    pub field_nt: Vec<f64>,
    /// Less the model's, nT.
    pub residual_nt: Vec<f64>,
    /// Standard uncertainty of the mean, nT.
    pub std_nt: Vec<f64>,
    /// Readings.
    pub readings: Vec<usize>,
}

/// The field of a coil along its axis, by coilcal: B(x) = B₀ + a x + b x² + c x⁴.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct CoilSurvey {
    /// The recording.
    pub recording: String,
    /// Mean current, A.
    pub current_a: f64,
    /// Current in the gradient coil, A, where the recording states it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gradient_coil_a: Option<f64>,
    /// B₀, nT.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre_nt: Option<Quantity>,
    /// a, nT/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_nt_per_m: Option<Quantity>,
    /// b, nT/m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_nt_per_m2: Option<Quantity>,
    /// c, nT/m⁴, where there are places enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fourth_nt_per_m4: Option<Quantity>,
    /// Where the mean field is farthest from the centre's, m.
    pub worst_position_m: f64,
    /// By how much there, nT.
    pub worst_departure_nt: Quantity,
    /// Largest field error within the stated distance off the centre, nT.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub off_centre: Option<OffCentre>,
    /// The places as columns.
    pub places: SurveyPlaces,
    /// Standard deviation of one reading, nT.
    pub noise_nt: f64,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// What a sensor off the centre sees.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OffCentre {
    /// How far off, m.
    pub distance_m: f64,
    /// Largest departure of the fitted field within that distance, nT.
    pub error_nt: Quantity,
}

/// The places of a survey as columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct SurveyPlaces {
    /// Along the coil's axis, m.
    pub position_m: Vec<f64>,
    /// Mean field less the centre's, nT.
    pub departure_nt: Vec<f64>,
    /// Its standard uncertainty, nT.
    pub std_nt: Vec<f64>,
    /// Mean field less the fitted one, nT.
    pub residual_nt: Vec<f64>,
}

/// How the gradient coil is to be set, from two surveys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GradientCoil {
    /// The place whose departure is brought to zero, m.
    pub position_m: f64,
    /// The current that does it, A.
    pub current_a: Quantity,
    /// Change from the first survey's, A.
    pub change_a: f64,
}
