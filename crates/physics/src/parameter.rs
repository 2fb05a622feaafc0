//! What of the chain may be fitted.

use common::Axis;

/// One parameter of the chain, to be fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Parameter {
    /// k of a coil, nT/A.
    CoilConstant(Axis),
    /// B0 of a coil, nT.
    CoilOffset(Axis),
    /// Turn of a coil along one of its two tangents, rad.
    CoilTurn(Axis, usize),
    /// Turn of a sensor along one of its two tangents, rad.
    SensorTurn(Axis, usize),
    /// k of a sensor.
    Sensitivity(Axis),
    /// O of a sensor, nT.
    SensorOffset(Axis),
    /// A parameter of an effect: number of the effect, number of its parameter.
    Effect(usize, usize),
}
