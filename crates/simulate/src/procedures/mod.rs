//! The procedures, one file each: what the report's own sequence is, and how it is planned.

mod axes;
mod coil_constant;
mod coil_gradient;
mod cross_field;
mod differential;
mod free_run;
mod nulling;
mod orbit;
mod reversal;
mod sensitivity;
mod sensor_noise;
mod sequence;
mod temperature;

pub use axes::{AcDrive, AxesProcedure, Drive, Orientations};
pub use coil_constant::CoilConstantProcedure;
pub use coil_gradient::CoilGradientProcedure;
pub use cross_field::CrossFieldProcedure;
pub use differential::DifferentialProcedure;
pub use free_run::FreeRun;
pub use nulling::{NullingProcedure, NullingSeries};
pub use orbit::{OrbitProcedure, OrbitTemperature};
pub use reversal::{DriftProcedure, ReversalProcedure};
pub use sensitivity::SensitivityProcedure;
pub use sensor_noise::{NoiseProcedure, NoiseSeries};
pub use sequence::Sequence;
pub use temperature::TemperatureProcedure;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One procedure of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
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
