//! Readings in nT, each with its drive, its orientation and its standard deviation.

use common::{Axis, Finding, Recording};
use nalgebra::{DMatrix, Vector3};
use physics::Unit;
use physics::frames::Orientation;

/// Factors on the standard deviations of readings, of constant drives and of AC amplitudes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseFactors {
    pub constant: f64,
    pub ac: f64,
}

impl NoiseFactors {
    /// As declared.
    pub const ONE: Self = Self::both(1.0);

    pub const fn both(factor: f64) -> Self {
        Self { constant: factor, ac: factor }
    }

    pub fn of(&self, reading: &Observation) -> f64 {
        if reading.constant { self.constant } else { self.ac }
    }
}

/// One reading of one sensor, or the mean of those of one drive; an AC run gives one for each sensor, its
/// amplitude in phase with the drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Number of its orientation in [`Observations::orientations`].
    pub orientation: usize,
    /// Number of its recording in the document.
    pub recording: usize,
    /// Row in the recording; of a mean, the first of its rows.
    pub row: usize,
    pub sensor: Axis,
    /// Field along each coil, k I + B0, nT.
    pub drive_nt: Vector3<f64>,
    /// k V + O, nT.
    pub value_nt: f64,
    /// Declared standard deviation, nT; 1 where none is declared.
    pub std_nt: f64,
    /// Field that the recording states besides the coils', GEO, nT.
    pub ambient_nt: Vector3<f64>,
    /// Whether constant fields and offsets are in it; they are not in an AC amplitude.
    pub constant: bool,
}

/// Where the readings' standard deviations come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseSource {
    /// `instrument.noise`, for every sensor.
    Declared,
    /// The noise beside the drive's frequency, where all recordings are AC runs.
    SineFits,
    /// Nowhere: they are all 1, and the residuals have to tell.
    Residuals,
}

/// One orientation of the block, in which one or more recordings were made.
#[derive(Clone, Debug, PartialEq)]
pub struct OrientationGroup {
    /// R and what the theodolites allow it.
    pub orientation: Orientation,
    pub recordings: Vec<String>,
}

/// All that the fit sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Observations {
    pub orientations: Vec<OrientationGroup>,
    pub readings: Vec<Observation>,
    pub together: Vec<Together>,
    pub noise: NoiseSource,
    /// Unit of the readings.
    pub unit: Unit,
    /// Sensors that were read.
    pub sensors: Vec<Axis>,
    /// Coils that were driven.
    pub coils: Vec<Axis>,
    pub phases: Vec<common::PhaseResult>,
    pub findings: Vec<Finding>,
}

impl Observations {
    /// The largest field along any coil, nT.
    pub fn largest_drive_nt(&self) -> f64 {
        self.readings.iter().map(|reading| reading.drive_nt.amax()).fold(0.0, f64::max)
    }

    /// The coil with the largest drive in a reading.
    pub fn main_coil(reading: &Observation) -> Axis {
        Axis::ALL[reading.drive_nt.iamax()]
    }
}

/// The readings of a sensor with the name of their column.
pub fn sensor_column(recording: &Recording, sensor: Axis) -> Option<(String, &[f64])> {
    [Unit::Volt, Unit::Nanotesla].into_iter().find_map(|unit| {
        let name = format!("sensor_{sensor}_{}", unit.suffix());
        recording.column(&name).map(|column| (name, column))
    })
}

/// Readings of one sensor in one recording, whose errors go together.
#[derive(Clone, Debug, PartialEq)]
pub struct Together {
    pub recording: usize,
    pub sensor: Axis,
    /// First rows of the means, in order.
    pub rows: Vec<usize>,
    /// Their covariance, nT².
    pub covariance: DMatrix<f64>,
}
