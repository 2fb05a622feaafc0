//! What is unknown of the base model, of the calibration and of each recording, and what is known of it beforehand.

use common::{AxesDirections, Axis, Calibration, Quantity, procedure, uncertainty};
use estimate::screen::Screen;
use faer::Mat;
use physics::{Parameter, Unit, frames};

use crate::Error;
use crate::channel::Channel;
use crate::observed::Observed;

/// How well an offset of a sensor is known at least, nT. In one orientation it is one with the offset of the
/// field, and only the sum is determined: without this, part of it could be anything, and with temperature it
/// would make any effect.
pub(super) const OFFSET_NT: f64 = 1000.0;
/// Share of a column's squared length that is rounding.
const SAME: f64 = 1e-9;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unknown {
    /// A parameter of the chain of readings in a unit.
    Chain(Parameter, Unit),
    /// The field left in the coils without drive, GEO, nT.
    Field(Axis),
    /// The level of a channel in a shield, nT; of opposite sign in the two positions of a reversal.
    Level(usize),
    /// The turn of the block from where the theodolites have it, about a SEN axis, in one setting; rad.
    Turn { setting: usize, about: usize },
}

/// Those of some columns that all the others say as well.
pub(super) fn undetermined(columns: &[&Vec<f64>], some: Vec<usize>) -> Result<Vec<usize>, Error> {
    let rows = columns.first().map_or(0, |column| column.len());
    let block = Mat::from_fn(rows, columns.len() + 1, |i, j| columns.get(j).map_or(0.0, |column| column[i]));
    let screen = Screen::of_rows(block.as_ref());
    let mut found = Vec::new();
    for k in some {
        let others: Vec<usize> = (0..columns.len()).filter(|other| *other != k).collect();
        if screen.given(&others)?.visible(k) < SAME {
            found.push(k);
        }
    }
    Ok(found)
}

/// All that may be unknown of the base model, with its uncertainty where it is known with one beforehand.
pub(super) fn possible(observed: &Observed<'_>, settings: &[usize]) -> Vec<(Unknown, Option<f64>)> {
    let mut all: Vec<(Unknown, Option<f64>)> = Vec::new();
    for unit in [Unit::Volt, Unit::Nanotesla] {
        all.extend(chain().map(|parameter| (Unknown::Chain(parameter, unit), None)));
    }
    let axes = observed.document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    if axes.is_some_and(|axes| axes.residual_field_nt.is_some()) {
        all.extend(Axis::ALL.map(|axis| (Unknown::Field(axis), None)));
    }
    // In a shield the field is not known.
    let shields = [procedure::SENSOR_NOISE, procedure::SENSOR_OFFSET_REVERSAL, procedure::OFFSET_DRIFT];
    let in_shield =
        |channel: &Channel| shields.contains(&observed.runs[channel.run].recording.procedure.as_str());
    let channels = observed.channels.iter().enumerate().filter(|(_, channel)| in_shield(channel));
    all.extend(channels.map(|(number, _)| (Unknown::Level(number), None)));
    for setting in 0..settings.iter().max().map_or(0, |last| last + 1) {
        let run = settings.iter().position(|s| *s == setting).unwrap_or(0);
        let uncertain = observed.runs[run].setting.context.orientation.uncertainty.diagonal();
        for about in (0..3).filter(|about| uncertain[*about] > 0.0) {
            all.push((Unknown::Turn { setting, about }, Some(uncertain[about])));
        }
    }
    all
}

pub fn chain() -> impl Iterator<Item = Parameter> {
    Axis::ALL.into_iter().flat_map(|axis| {
        [
            Parameter::Sensitivity(axis),
            Parameter::SensorOffset(axis),
            Parameter::SensorTurn(axis, 0),
            Parameter::SensorTurn(axis, 1),
            Parameter::CoilConstant(axis),
            Parameter::CoilOffset(axis),
            Parameter::CoilTurn(axis, 0),
            Parameter::CoilTurn(axis, 1),
        ]
    })
}

/// The setting of the block of each run: one orientation is one, unless recordings name it otherwise.
pub(super) fn settings(observed: &Observed<'_>) -> Vec<usize> {
    let mut seen: Vec<(Option<&str>, nalgebra::Matrix3<f64>)> = Vec::new();
    observed
        .runs
        .iter()
        .map(|run| {
            let key = (run.recording.conditions.setting.as_deref(), run.setting.context.orientation.rotation);
            seen.iter().position(|known| *known == key).unwrap_or_else(|| {
                seen.push(key);
                seen.len() - 1
            })
        })
        .collect()
}

/// Where a calibration states a constant, made where it is missing; None of what is no constant (turns, levels,
/// effects).
pub fn place<'c>(calibration: &'c mut Calibration, unknown: &Unknown) -> Option<&'c mut Option<Quantity>> {
    let sensor = |calibration: &'c mut Calibration, axis: Axis| {
        calibration.sensors.get_or_insert_default().entry(axis).get_or_insert_default()
    };
    let coil = |calibration: &'c mut Calibration, axis: Axis| {
        calibration.coils.get_or_insert_default().entry(axis).get_or_insert_default()
    };
    Some(match unknown {
        Unknown::Chain(Parameter::Sensitivity(axis), Unit::Volt) => {
            &mut sensor(calibration, *axis).sensitivity_nt_per_v
        }
        Unknown::Chain(Parameter::Sensitivity(axis), Unit::Nanotesla) => {
            &mut sensor(calibration, *axis).sensitivity_nt_per_nt
        }
        Unknown::Chain(Parameter::SensorOffset(axis), _) => &mut sensor(calibration, *axis).offset_nt,
        Unknown::Chain(Parameter::CoilConstant(axis), _) => &mut coil(calibration, *axis).constant_nt_per_a,
        Unknown::Chain(Parameter::CoilOffset(axis), _) => &mut coil(calibration, *axis).offset_nt,
        Unknown::Field(axis) => {
            calibration.axes.get_or_insert_default().residual_field_nt.get_or_insert_default().entry(*axis)
        }
        _ => return None,
    })
}

/// The same of what a fit moves: what axescal adds to an offset has the uncertainty of the sum.
pub fn moving_place<'c>(
    calibration: &'c mut Calibration,
    unknown: &Unknown,
) -> Option<&'c mut Option<Quantity>> {
    match unknown {
        Unknown::Chain(Parameter::SensorOffset(axis), _) if is_sum(calibration, *axis) => {
            Some(calibration.axes.as_mut()?.offsets_nt.as_mut()?.entry(*axis))
        }
        _ => place(calibration, unknown),
    }
}

/// The path of a constant in the joint uncertainty; of a sensor's offset that of the sum, where axescal found
/// something to be added. None of what is no constant.
pub fn path(calibration: Option<&Calibration>, unknown: &Unknown) -> Option<String> {
    Some(match unknown {
        Unknown::Chain(Parameter::Sensitivity(axis), unit) => uncertainty::sensitivity(*axis, unit.suffix()),
        Unknown::Chain(Parameter::SensorOffset(axis), _)
            if calibration.is_some_and(|calibration| is_sum(calibration, *axis)) =>
        {
            uncertainty::added_offset(*axis)
        }
        Unknown::Chain(Parameter::SensorOffset(axis), _) => uncertainty::sensor_offset(*axis),
        Unknown::Chain(Parameter::CoilConstant(axis), _) => uncertainty::coil_constant(*axis),
        Unknown::Chain(Parameter::CoilOffset(axis), _) => uncertainty::coil_offset(*axis),
        Unknown::Field(axis) => uncertainty::residual_field(*axis),
        _ => return None,
    })
}

fn is_sum(calibration: &Calibration, axis: Axis) -> bool {
    let added = calibration.axes.as_ref().and_then(|axes| axes.offsets_nt.as_ref()?.get(axis));
    added.is_some_and(|added| added.std().is_some())
}

/// Standard uncertainty that a calibration states of a constant; none where it states none.
pub fn stated_std(calibration: &Calibration, unknown: &Unknown) -> Option<f64> {
    let axes = || calibration.axes.as_ref();
    let turn = |of: &Option<AxesDirections>, axis: Axis| {
        of.as_ref()?.std_arcsec.as_ref()?.get(axis).map(|std| std * frames::ARCSEC)
    };
    let std = match unknown {
        Unknown::Chain(Parameter::Sensitivity(axis), Unit::Volt) => {
            calibration.sensor(*axis)?.sensitivity_nt_per_v.as_ref()?.std()
        }
        Unknown::Chain(Parameter::Sensitivity(axis), Unit::Nanotesla) => {
            calibration.sensor(*axis)?.sensitivity_nt_per_nt.as_ref()?.std()
        }
        Unknown::Chain(Parameter::SensorOffset(axis), _) => {
            calibration.sensor(*axis)?.offset_nt.as_ref()?.std()
        }
        Unknown::Chain(Parameter::CoilConstant(axis), _) => {
            calibration.coil(*axis)?.constant_nt_per_a.as_ref()?.std()
        }
        Unknown::Chain(Parameter::CoilOffset(axis), _) => calibration.coil(*axis)?.offset_nt.as_ref()?.std(),
        Unknown::Chain(Parameter::SensorTurn(axis, _), _) => turn(&axes()?.sensors, *axis),
        Unknown::Chain(Parameter::CoilTurn(axis, _), _) => turn(&axes()?.coils, *axis),
        Unknown::Field(axis) => axes()?.residual_field_nt.as_ref()?.get(*axis)?.std(),
        Unknown::Chain(Parameter::Effect(..), _) | Unknown::Level(_) | Unknown::Turn { .. } => None,
    };
    std.filter(|std| *std > 0.0)
}
