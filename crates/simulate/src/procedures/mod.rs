//! The procedures: what the report's own sequence is, and how it is planned.

mod axes;
mod coil;
mod free_run;
mod reversal;
mod sensitivity;
mod series;
mod temperature;

pub use axes::{AcDrive, AxesProcedure, Drive, Orientations};
pub use coil::{CoilConstantProcedure, CoilGradientProcedure};
pub use free_run::{FreeRun, OrbitProcedure, OrbitTemperature};
pub use reversal::{DriftProcedure, ReversalProcedure};
pub use sensitivity::{CrossFieldProcedure, SensitivityProcedure};
pub use series::{DifferentialProcedure, NoiseProcedure, NoiseSeries, NullingProcedure, NullingSeries};
pub use temperature::TemperatureProcedure;

use common::Error;
use serde::{Deserialize, Serialize};

use crate::bench::Bench;
use crate::planned::Planned;

/// A procedure as a sequence of recordings.
pub trait Sequence {
    /// Rows that it gives; refuses sizes that make no sense. Called before anything is planned.
    fn rows(&self, bench: &Bench<'_>, path: &str) -> Result<f64, Error>;

    /// Its recordings, without readings.
    fn plan(&self, bench: &Bench<'_>, path: &str) -> Result<Vec<Planned>, Error>;
}

/// Thirty days, s.
const MONTH_S: u32 = 2_592_000;

/// A whole number for a key that is absent.
fn whole<const VALUE: u32>() -> f64 {
    f64::from(VALUE)
}

/// A count for a key that is absent.
fn count<const VALUE: usize>() -> usize {
    VALUE
}

/// One procedure of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "procedure", rename_all = "snake_case")]
pub enum Procedure {
    /// Field of a coil against its current.
    CoilConstant(CoilConstantProcedure),
    /// Field of a coil along its axis.
    CoilGradient(CoilGradientProcedure),
    /// What the nulling leaves, in the conditions of the site.
    NullingResidual(NullingProcedure),
    /// Readings of each sensor against a coil's field.
    SensorSensitivity(SensitivityProcedure),
    /// Offsets by turning the sensor.
    SensorOffsetReversal(ReversalProcedure),
    /// Noise in a shield.
    SensorNoise(NoiseProcedure),
    /// Offsets from date to date.
    OffsetDrift(DriftProcedure),
    /// Sensitivity and offset at many temperatures.
    TemperatureRun(TemperatureProcedure),
    /// Sensitivity and offset with fields across the sensor.
    CrossField(CrossFieldProcedure),
    /// Directions of sensors and coils.
    AxesOrientation(AxesProcedure),
    /// Two magnetometers side by side.
    Differential(DifferentialProcedure),
    /// Any drive.
    FreeRun(Box<FreeRun>),
    /// A free run in orbit.
    Orbit(Box<OrbitProcedure>),
}

impl Procedure {
    /// What it does.
    pub fn sequence(&self) -> &dyn Sequence {
        match self {
            Procedure::CoilConstant(procedure) => procedure,
            Procedure::CoilGradient(procedure) => procedure,
            Procedure::NullingResidual(procedure) => procedure,
            Procedure::SensorSensitivity(procedure) => procedure,
            Procedure::SensorOffsetReversal(procedure) => procedure,
            Procedure::SensorNoise(procedure) => procedure,
            Procedure::OffsetDrift(procedure) => procedure,
            Procedure::TemperatureRun(procedure) => procedure,
            Procedure::CrossField(procedure) => procedure,
            Procedure::AxesOrientation(procedure) => procedure,
            Procedure::Differential(procedure) => procedure,
            Procedure::FreeRun(procedure) => procedure.as_ref(),
            Procedure::Orbit(procedure) => procedure.as_ref(),
        }
    }
}
