use common::{Axis, Calibration, Columns, Conditions, Facility, Instrument, Matrix3x3, Model, PerAxis};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is to be simulated: the facility and the instrument as they are stated, what they truly are,
/// and the procedures in order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Format version, 1.
    pub fluxcal: u64,
    /// Free text; the document's title.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// Seed of all noise.
    #[serde(default)]
    pub seed: u64,
    /// The facility, as the document will state it. Its theodolite uncertainty is also what the simulated
    /// theodolites err by.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facility: Option<Facility>,
    /// The instrument, as the document will state it; its noise and quantisation are applied.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instrument: Option<Instrument>,
    /// The calibration that the document will state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<Calibration>,
    /// What is true; where it says nothing, what is stated is true.
    #[serde(default)]
    pub truth: TruthPlan,
    /// The procedures.
    pub procedures: Vec<Procedure>,
}

/// The truth behind the recordings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TruthPlan {
    /// True constants and axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration: Option<Calibration>,
    /// Effects that act on the readings.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<Model>,
    /// Field at the sensors with no drive, GEO, nT.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub residual_field_nt: Option<PerAxis<f64>>,
}

/// One procedure of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "procedure", rename_all = "snake_case")]
pub enum Procedure {
    /// Directions of sensors and coils.
    AxesOrientation(AxesProcedure),
    /// Any drive.
    FreeRun(Box<FreeRun>),
}

/// Turn the block through orientations and drive the coils in each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxesProcedure {
    /// Beginning of the recordings' ids.
    pub id: String,
    /// The orientations.
    pub orientations: Orientations,
    /// Field of a named drive, nT.
    pub drive_nt: f64,
    /// The drives in each orientation.
    #[serde(default = "one_coil_after_the_other")]
    pub drives: Vec<Drive>,
    /// Readings of each drive.
    #[serde(default = "one")]
    pub repeats: usize,
    /// The sensors that are read; absent: those of the instrument, else all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensors: Option<Vec<Axis>>,
    /// Write the theodolites' angles, not the matrix.
    #[serde(default)]
    pub theodolite_angles: bool,
    /// How far the fixture may miss its nominal orientation (standard deviation), arcmin.
    #[serde(default)]
    pub fixture_std_arcmin: f64,
    /// Drive with a sine; absent: with constant currents.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ac: Option<AcDrive>,
}

/// A sinusoidal drive of all coils in phase (NASA, "Errors in Magnetic Axis Orientation").
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AcDrive {
    /// Frequency, Hz.
    pub hz: f64,
    /// Cycles recorded.
    pub cycles: f64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Amplitude on the coils that a drive does not name, nT: the dither.
    #[serde(default)]
    pub dither_nt: f64,
}

/// Orientations by name or one by one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "\"cube\", \"nasa_table_3\", or a list of 3x3 rotations")]
pub enum Orientations {
    /// `cube` (24) or `nasa_table_3` (7).
    Named(String),
    /// R, GEO -> SEN, each.
    List(Vec<Matrix3x3>),
}

/// A drive by name or as a vector.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "\"x\", \"-x\", \"zero\", or [x, y, z] in nT")]
pub enum Drive {
    /// `x`, `-x`, … at the procedure's field, or `zero`.
    Named(String),
    /// Field of each coil, nT.
    Vector([f64; 3]),
}

/// A recording with columns of its own; the readings are added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreeRun {
    /// The recording's id.
    pub id: String,
    /// What holds throughout.
    #[serde(default)]
    pub conditions: Conditions,
    /// Times, drive, temperatures.
    pub columns: Columns,
}

fn one_coil_after_the_other() -> Vec<Drive> {
    Axis::ALL.iter().map(|axis| Drive::Named(axis.to_string())).collect()
}

fn one() -> usize {
    1
}
