//! What is known beforehand of the constants of the chain.

use common::{Axis, Calibration, Document};
use nalgebra::Vector3;
use physics::{Parameter, Unit, frames};

use super::state::Model;
use super::unknown::{Instrument, Unknown, instrument_of};

impl Model<'_> {
    /// Holds the constants of the sensors within a share of themselves, or in radians, offsets within that of
    /// the field and within the scatter of the difference as it came, each together with what the calibration
    /// states of it. An offset of which nothing is stated is held about its part in the difference's level:
    /// along the field, for across it the level says nothing.
    pub fn hold(&mut self, document: &Document, share: f64, came: &[f64]) {
        let readings = self.observed.channels.iter().flat_map(|channel| &channel.readings);
        let rows = self.observed.rows as f64;
        let field = readings.sum::<f64>() / rows;
        let level = came.iter().sum::<f64>() / rows;
        let scatter = (came.iter().map(|value| (value - level).powi(2)).sum::<f64>() / rows).sqrt();
        let shares = self.observed.channels.iter().flat_map(|channel| &channel.shares);
        let along = shares.sum::<Vector3<f64>>() / rows;
        for (k, unknown) in self.unknowns.iter().enumerate() {
            let Unknown::Chain(parameter, instrument) = unknown else { continue };
            let mut runs = self.observed.runs.iter();
            let basic = runs.find(|run| instrument_of(run) == *instrument).map(|run| &run.setting.basic);
            let stated =
                document.calibration.as_ref().and_then(|calibration| stated_std(calibration, unknown));
            let std = match parameter {
                Parameter::Sensitivity(axis) => {
                    basic.map(|basic| share * basic.sensors[axis.index()].sensitivity.abs())
                }
                Parameter::SensorOffset(axis) => {
                    let own = -level * along[axis.index()] / along.norm_squared();
                    self.centres[k] = if stated.is_none() && own.is_finite() { own } else { 0.0 };
                    Some(scatter.hypot(share * field))
                }
                Parameter::SensorTurn(..) => Some(share),
                _ => None,
            };
            self.priors[k] = std.map(|std| std.hypot(stated.unwrap_or(0.0)));
        }
    }
}

/// Standard uncertainty that a calibration states of a constant; none where it states none.
pub fn stated_std(calibration: &Calibration, unknown: &Unknown) -> Option<f64> {
    let sensor = |axis: Axis| calibration.sensor(axis);
    let coil = |axis: Axis| calibration.coil(axis);
    let axes = || calibration.axes.as_ref();
    let std = match unknown {
        Unknown::Chain(parameter, Instrument::Read(unit)) => match parameter {
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
        Unknown::Chain(_, Instrument::Pair) | Unknown::Level(_) | Unknown::Turn { .. } => None,
    };
    std.filter(|std| *std > 0.0)
}
