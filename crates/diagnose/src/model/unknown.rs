//! What is unknown of the base model: of the calibration and of each recording.

use common::{Axis, Document};
use estimate::screen::Screen;
use faer::Mat;
use physics::{Parameter, Unit};

use crate::Error;
use crate::observed::Observed;

/// How well an offset of a sensor is known at least, nT. In one orientation it is one with the offset of the
/// field, and only the sum is determined: without this, part of it could be anything, and with temperature it
/// would make any effect.
pub(super) const OFFSET_NT: f64 = 1000.0;
/// Share of a column's squared length that is rounding.
const SAME: f64 = 1e-9;

/// One unknown of the base model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unknown {
    /// A parameter of the chain of readings in a unit.
    Chain(Parameter, Unit),
    /// The field left in the coils without drive, GEO, nT.
    Field(Axis),
    /// The level of a channel in a shield, nT; of opposite sign in the two positions of a reversal.
    Level(usize),
    /// The turn of the block from where the theodolites have it, about a SEN axis, in one setting; rad.
    Turn {
        /// Number of the setting.
        setting: usize,
        /// The axis.
        about: usize,
    },
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
pub(super) fn possible(
    document: &Document,
    observed: &Observed<'_>,
    settings: &[usize],
) -> Vec<(Unknown, Option<f64>)> {
    let mut all: Vec<(Unknown, Option<f64>)> = Vec::new();
    for unit in [Unit::Volt, Unit::Nanotesla] {
        all.extend(chain().map(|parameter| (Unknown::Chain(parameter, unit), None)));
    }
    let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
    if axes.is_some_and(|axes| axes.residual_field_nt.is_some()) {
        all.extend(Axis::ALL.map(|axis| (Unknown::Field(axis), None)));
    }
    let channels = observed.channels.iter().enumerate();
    all.extend(
        channels.filter(|(_, c)| observed.runs[c.run].in_shield()).map(|(k, _)| (Unknown::Level(k), None)),
    );
    for setting in 0..settings.iter().max().map_or(0, |last| last + 1) {
        let run = settings.iter().position(|s| *s == setting).unwrap_or(0);
        let uncertain = observed.runs[run].setting.context.orientation.uncertainty.diagonal();
        for about in (0..3).filter(|about| uncertain[*about] > 0.0) {
            all.push((Unknown::Turn { setting, about }, Some(uncertain[about])));
        }
    }
    all
}

/// The parameters of the chain.
pub(super) fn chain() -> impl Iterator<Item = Parameter> {
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

/// The setting of the block of each run: recordings of one orientation share it, unless they name it
/// otherwise.
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
