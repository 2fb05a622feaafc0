//! What is known beforehand of the constants of the chain.

use common::{Axis, Calibration};
use physics::{Parameter, Unit, frames};

use super::unknown::Unknown;

/// Standard uncertainty that a calibration states of a constant; none where it states none.
pub fn stated_std(calibration: &Calibration, unknown: &Unknown) -> Option<f64> {
    let sensor = |axis: Axis| calibration.sensor(axis);
    let coil = |axis: Axis| calibration.coil(axis);
    let axes = || calibration.axes.as_ref();
    let std = match unknown {
        Unknown::Chain(parameter, unit) => match parameter {
            Parameter::Sensitivity(axis) => match unit {
                Unit::Volt => sensor(*axis)?.sensitivity_nt_per_v.as_ref()?.std(),
                Unit::Nanotesla => sensor(*axis)?.sensitivity_nt_per_nt.as_ref()?.std(),
            },
            Parameter::SensorOffset(axis) => sensor(*axis)?.offset_nt.as_ref()?.std(),
            Parameter::CoilConstant(axis) => coil(*axis)?.constant_nt_per_a.as_ref()?.std(),
            Parameter::CoilOffset(axis) => coil(*axis)?.offset_nt.as_ref()?.std(),
            Parameter::SensorTurn(axis, _) => {
                axes()?.sensors.as_ref()?.std_arcsec.as_ref()?.get(*axis).map(|std| std * frames::ARCSEC)
            }
            Parameter::CoilTurn(axis, _) => {
                axes()?.coils.as_ref()?.std_arcsec.as_ref()?.get(*axis).map(|std| std * frames::ARCSEC)
            }
            Parameter::Effect(..) => None,
        },
        Unknown::Field(axis) => axes()?.residual_field_nt.as_ref()?.get(*axis)?.std(),
        Unknown::Level(_) | Unknown::Turn { .. } => None,
    };
    std.filter(|std| *std > 0.0)
}
