use serde::{Deserialize, Serialize};

use crate::{Axis, Extra, Findings, Matrix3x3, OneOrEach, PerAxis, Quantity};

/// Directions of the sensors in SEN and of the coils in GEO, with what stands behind them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AxesCalibration {
    /// μ: columns = unit vectors of the sensors' magnetic axes in SEN.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensors: Option<AxesDirections>,
    /// η: columns = unit vectors of the coils' axes in GEO.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coils: Option<AxesDirections>,
    /// η as it was given before the readings spoke, where coils were taken as known; `coils` is then what
    /// both say together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub known_coils: Option<AxesDirections>,
    /// Covariance between `sensors.matrix` (rows) and `coils.matrix` (columns), each in its
    /// `covariance_order`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cross_covariance: Option<Vec<Vec<f64>>>,
    /// Field left at the sensors with no drive, in GEO, nT.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual_field_nt: Option<PerAxis<Quantity>>,
    /// What is to be added to each sensor's offset in `calibration.sensors`, nT (B = k V + O).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offsets_nt: Option<PerAxis<Quantity>>,
    /// Relative scales of sensors and coils, where they were left free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scales: Option<ScalesResult>,
    /// One sensor with one coil: the constrained solution beside the report's unconstrained one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pair: Option<PairComparison>,
    /// The result for one sensor or one coil alone, beside the result for all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub subset: Option<Box<AxesCalibration>>,
    /// Each orientation: its residuals and the small rotation by which it was corrected.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub orientations: Vec<OrientationResult>,
    /// Phases of the sensors in AC runs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<PhaseResult>,
    /// How the solution was found and how well it fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fit: Option<AxesFit>,
    /// What the recordings did not show and was assumed, with the bound of its effect.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub assumptions: Vec<Assumption>,
    /// Outliers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub doubtful: Vec<DoubtfulReading>,
    /// What looks wrong, in words.
    #[serde(flatten)]
    pub findings: Findings,
    /// Every reading: residual, leverage and leave-one-out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub readings: Option<AxesReadings>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A set of directions. With all three axes they stand in `matrix`; with fewer in `directions`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AxesDirections {
    /// Columns = unit vectors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub matrix: Option<Matrix3x3>,
    /// Unit vectors by axis, where not all three are known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directions: Option<PerAxis<[f64; 3]>>,
    /// Largest standard uncertainty of each direction over all ways it may turn, arcsec.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub std_arcsec: Option<OneOrEach>,
    /// Angle between each direction and its nominal axis, arcsec.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub off_nominal_arcsec: Option<PerAxis<Quantity>>,
    /// 90° less the angle between two axes, arcsec, keyed `xy`, `yz`, `xz`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub non_orthogonality_arcsec: Option<indexmap::IndexMap<String, Quantity>>,
    /// Covariance of the direction cosines (rad²), in `covariance_order`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covariance: Option<Vec<Vec<f64>>>,
    /// The keys that `covariance` runs over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub covariance_order: Option<Vec<String>>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl AxesDirections {
    /// The unit vector of an axis.
    pub fn direction(&self, axis: Axis) -> Option<[f64; 3]> {
        match &self.matrix {
            Some(matrix) => Some([0, 1, 2].map(|row| matrix[row][axis.index()])),
            None => self.directions.as_ref()?.get(axis).copied(),
        }
    }
}

/// Directions and five of the six scales from the same readings (17 of 18 unknowns).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ScalesResult {
    /// Reading over calibrated field for each sensor, relative to the mean of the sensors.
    pub sensors: PerAxis<ScaleResult>,
    /// Field over calibrated drive for each coil, relative to the mean of the coils.
    pub coils: PerAxis<ScaleResult>,
    /// Common factor of sensors and coils together: the one that an absolute reading has to split.
    pub common: ScaleResult,
    /// What the numbers say, in words.
    pub verdict: String,
}

/// One scale with its distance from what the calibration promises.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ScaleResult {
    /// Scale as fitted.
    pub value: f64,
    /// Its standard uncertainty from the fit.
    pub std: f64,
    /// Standard uncertainty of the calibration's own promise, from coilcal and sensorcal.
    pub calibration_std: f64,
    /// Distance from 1 over both uncertainties joined.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigmas: Option<f64>,
    /// Probability of a distance at least so large when nothing is wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_value: Option<f64>,
}

/// One sensor and one coil: 4 unknowns on the unit spheres beside 6 unconstrained ones (NASA MAGCAL1 and
/// MAGCAL).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct PairComparison {
    /// The sensor.
    pub sensor: String,
    /// The coil.
    pub coil: String,
    /// Unconstrained minimum-norm vector of the sensor in SEN (its length is not 1).
    pub unconstrained_sensor: [f64; 3],
    /// Unconstrained minimum-norm vector of the coil in GEO.
    pub unconstrained_coil: [f64; 3],
    /// Rank of the unconstrained problem, of 6; sensor and coil can trade their lengths, so 5 at most.
    pub unconstrained_rank: usize,
    /// Rms of what the unconstrained model cannot reach, nT: 0 when the data are compatible.
    pub incompatibility_rms_nt: f64,
    /// Angle between the constrained and the unconstrained direction of the sensor, arcsec.
    pub sensor_difference_arcsec: f64,
    /// The same for the coil, arcsec.
    pub coil_difference_arcsec: f64,
}

/// One orientation of the sensor block.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct OrientationResult {
    /// The recordings made in it.
    pub recordings: Vec<String>,
    /// Number of readings.
    pub readings: usize,
    /// Rms of the residuals, nT.
    pub rms_nt: f64,
    /// Small rotation about the SEN axes by which R was corrected, arcsec.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub correction_arcsec: Option<PerAxis<Quantity>>,
    /// How far R as given had to move to the nearest rotation, arcsec.
    pub orthogonalised_by_arcsec: f64,
}

/// Phase of one sensor behind the drive in an AC run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PhaseResult {
    /// The sensor.
    pub sensor: Axis,
    /// Frequency of the drive, Hz.
    pub drive_hz: f64,
    /// Phase ahead of the drive, rad (negative: the reading lags).
    pub phase_rad: Quantity,
    /// Probability of a phase at least so large when there is none.
    pub p_value: f64,
    /// The delay that would make it, s.
    pub delay_s: f64,
}

/// How the solution was found and how well it fits.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AxesFit {
    /// `coils unknown` or `coils known`.
    pub method: String,
    /// Number of readings that entered.
    pub readings: usize,
    /// Number of unknowns, nuisance ones included.
    pub unknowns: usize,
    /// Rank that the readings gave.
    pub rank: usize,
    /// Singular values of the weighted problem with columns of unit length, largest first.
    pub singular_values: Vec<f64>,
    /// Degrees of freedom left.
    pub degrees_of_freedom: f64,
    /// Rms of the residuals, nT.
    pub rms_nt: f64,
    /// Standard deviation of a reading behind the uncertainties, nT.
    pub noise_nt: f64,
    /// Where that comes from: `declared`, `sine fits` or `residuals`; the first two may be `…, scaled to the
    /// residuals`.
    pub noise_source: String,
    /// χ² of the residuals over the declared noise, where it is declared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chi_squared: Option<f64>,
    /// Probability of so large a χ².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chi_squared_p: Option<f64>,
    /// Factor from a standard uncertainty to a 95 % interval.
    pub coverage_factor_95: f64,
    /// Each step of the Gauss-Newton iteration.
    pub iterations: Vec<IterationStep>,
}

/// One step of the iteration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct IterationStep {
    /// Rms of the residuals before the step, nT.
    pub rms_nt: f64,
    /// Largest turn of a direction in the step, arcsec.
    pub turn_arcsec: f64,
    /// Rank of the linearised problem.
    pub rank: usize,
}

/// Something that the recordings could not show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Assumption {
    /// What was assumed.
    pub assumed: String,
    /// Largest turn of any direction for one nT of it, arcsec.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arcsec_per_nt: Option<f64>,
    /// Largest standard uncertainty of any direction for one arcsecond of standard uncertainty in it, arcsec.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arcsec_per_arcsec: Option<f64>,
}

/// A reading that does not belong to the rest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DoubtfulReading {
    /// The recording.
    pub recording: String,
    /// Its number among the orientations, from 1.
    pub orientation: usize,
    /// The row, from 0; for an AC run the whole run.
    pub row: usize,
    /// The coil with the largest drive.
    pub coil: Axis,
    /// The sensor.
    pub sensor: Axis,
    /// Reading less the prediction made without it, nT.
    pub leave_one_out_nt: f64,
    /// That over its standard deviation, estimated without it.
    pub t: f64,
    /// Probability that the largest of all readings is so far out, when nothing is wrong.
    pub p_adjusted: f64,
}

/// Every reading of the fit, as columns.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AxesReadings {
    /// Number of the orientation, from 1.
    pub orientation: Vec<usize>,
    /// The recording.
    pub recording: Vec<String>,
    /// Row in the recording, from 0.
    pub row: Vec<usize>,
    /// The coil with the largest drive.
    pub coil: Vec<Axis>,
    /// The sensor.
    pub sensor: Vec<Axis>,
    /// Reading less prediction, nT.
    pub residual_nt: Vec<f64>,
    /// Share of the prediction that the reading itself decides, 0 to 1.
    pub leverage: Vec<f64>,
    /// Reading less the prediction made without it, nT; after a robust fit as if all weights were 1.
    pub leave_one_out_nt: Vec<f64>,
    /// That over its standard deviation, estimated without it.
    pub t: Vec<f64>,
    /// Weight in a robust fit, 0 to 1; absent otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<Vec<f64>>,
}
