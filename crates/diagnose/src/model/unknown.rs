//! The base model: what is unknown of the calibration and of each recording, and what is predicted of a
//! recording for it.

use common::{Axis, Document};
use estimate::screen::{Products, Screen};
use faer::Mat;
use nalgebra::Vector3;
use physics::{Basic, Context, Parameter, Prediction, Unit, frames};
use rayon::prelude::*;

use super::{Model, Seen, State};
use crate::Error;
use crate::channel::Run;
use crate::magnitude;
use crate::observed::Observed;

/// How well an offset of a sensor is known at least, nT. In one orientation it is one with the offset of the
/// field, and only the sum is determined: without this, part of it could be anything, and with temperature it
/// would make any effect.
pub(super) const OFFSET_NT: f64 = 1000.0;
/// Share of a column's squared length that is rounding.
const SAME: f64 = 1e-9;

/// Step of the differences by which turns of the block enter, rad.
const TURN_RAD: f64 = 1e-5;

/// Whose constants a parameter of the chain belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instrument {
    /// The magnetometer, by the unit of its readings.
    Read(Unit),
    /// The two of a differential recording.
    Pair,
}

/// One unknown of the base model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unknown {
    /// A parameter of the chain.
    Chain(Parameter, Instrument),
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

/// Columns that the others say as well.
pub(super) fn undetermined(columns: &[&Vec<f64>]) -> Result<Vec<usize>, Error> {
    let rows = columns.first().map_or(0, |column| column.len());
    let mut products = Products::of(columns.len());
    let block = Mat::from_fn(rows, columns.len() + 1, |i, j| columns.get(j).map_or(0.0, |column| column[i]));
    products.push(block.as_ref());
    let screen = Screen::of(&products);
    let alone = |k: usize| -> Result<bool, Error> {
        let others: Vec<usize> = (0..columns.len()).filter(|other| *other != k).collect();
        Ok(screen.given(&others)?.visible(k) < SAME)
    };
    let mut found = Vec::new();
    for k in 0..columns.len() {
        if alone(k)? {
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
    for instrument in [Instrument::Read(Unit::Volt), Instrument::Read(Unit::Nanotesla), Instrument::Pair] {
        all.extend(chain().map(|parameter| (Unknown::Chain(parameter, instrument), None)));
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

impl<'a> Model<'a> {
    /// Takes three turns of sensors out of the unknowns, so that no turn of all sensors together is left
    /// among them, which magnitudes alone do not show: both of x, and that of y which goes more about x.
    pub(super) fn without_common_turn(&self, felt: &mut Vec<usize>) {
        let about_x = |instrument: Instrument| {
            let run = (0..self.observed.runs.len()).find(|run| self.instrument(*run) == instrument)?;
            let mu = &self.observed.runs[run].setting.basic.mu;
            let moved = mu.column(0).cross(&mu.column(1));
            let [first, second] =
                frames::tangents(&mu.column(1).into()).map(|tangent| tangent.dot(&moved).abs());
            Some(usize::from(second > first))
        };
        felt.retain(|unknown| match self.unknowns[*unknown] {
            Unknown::Chain(Parameter::SensorTurn(Axis::X, _), _) => false,
            Unknown::Chain(Parameter::SensorTurn(Axis::Y, turn), instrument) => {
                about_x(instrument) != Some(turn)
            }
            _ => true,
        });
    }

    /// Derivatives of what is predicted by the unknowns of the base model at a state.
    pub fn base_columns(&self, state: &State) -> Result<Vec<Vec<f64>>, Error> {
        let runs: Vec<Vec<Vec<f64>>> = (0..self.observed.runs.len())
            .into_par_iter()
            .map(|run| {
                let moving = |unknown: &Unknown| match unknown {
                    Unknown::Chain(parameter, instrument) if *instrument == self.instrument(run) => {
                        self.local(state, run, *parameter)
                    }
                    _ => Vec::new(),
                };
                let wanted = self.unknowns.iter().flat_map(moving).map(|(local, _)| local);
                let parameters: Vec<Parameter> =
                    chain().filter(|own| wanted.clone().any(|local| local == *own)).collect();
                let Seen { basic, prediction, derivatives } = self.predict(state, run, &parameters)?;
                let length: usize = self.observed.channels_of(run).map(|channel| channel.rows.len()).sum();
                let stack = |derivative: &Prediction| -> Vec<f64> {
                    let channels = self.observed.channels_of(run);
                    channels.flat_map(|channel| channel.derivative(&basic, &prediction, derivative)).collect()
                };
                let moved = |unknown: usize, step: f64| -> Result<Vec<f64>, Error> {
                    let values = |sign: f64| -> Result<Vec<f64>, Error> {
                        let mut state = state.clone();
                        state.base[unknown] += sign * step;
                        let seen = self.predict(&state, run, &[])?;
                        let channels = self.observed.channels_of(run);
                        Ok(channels.flat_map(|c| c.predicted(&seen.basic, &seen.prediction)).collect())
                    };
                    let (above, below) = (values(1.0)?, values(-1.0)?);
                    Ok(above.iter().zip(below).map(|(a, b)| (a - b) / (2.0 * step)).collect())
                };
                self.unknowns
                    .iter()
                    .enumerate()
                    .map(|(number, unknown)| match unknown {
                        Unknown::Chain(parameter, instrument) if *instrument == self.instrument(run) => {
                            let mut column = vec![0.0; length];
                            for (local, weight) in self.local(state, run, *parameter) {
                                let at = parameters.iter().position(|p| *p == local).unwrap_or(0);
                                let Some(derivative) = derivatives[at].as_ref() else { continue };
                                column.iter_mut().zip(stack(derivative)).for_each(|(c, d)| *c += weight * d);
                            }
                            Ok(column)
                        }
                        Unknown::Field(_) if self.observed.runs[run].setting.context.in_coils => {
                            moved(number, 1.0)
                        }
                        Unknown::Turn { setting, .. } if *setting == self.settings[run] => {
                            moved(number, TURN_RAD)
                        }
                        _ => Ok(vec![0.0; length]),
                    })
                    .collect::<Result<Vec<_>, Error>>()
            })
            .collect::<Result<_, Error>>()?;
        Ok((0..self.unknowns.len())
            .map(|k| match self.unknowns[k] {
                Unknown::Level(channel) => self.level(channel),
                _ => runs.iter().flat_map(|run| run[k].iter().copied()).collect(),
            })
            .collect())
    }

    /// What moves when a parameter of the chain moves. A turn counts along the tangents of the direction as
    /// the document has it; the chain's derivatives are along those of the direction as it stands.
    fn local(&self, state: &State, run: usize, parameter: Parameter) -> Vec<(Parameter, f64)> {
        let (now, _) = self.setting(state, run);
        let before = &self.observed.runs[run].setting.basic;
        let (axis, which, before, now, of): (_, _, _, _, fn(Axis, usize) -> Parameter) = match parameter {
            Parameter::SensorTurn(axis, which) => (axis, which, &before.mu, &now.mu, Parameter::SensorTurn),
            Parameter::CoilTurn(axis, which) => (axis, which, &before.eta, &now.eta, Parameter::CoilTurn),
            other => return vec![(other, 1.0)],
        };
        let unit = |matrix: &nalgebra::Matrix3<f64>| matrix.column(axis.index()).into_owned().normalize();
        let (before, now) = (unit(before), unit(now));
        let along = frames::tangents(&before)[which];
        // (u + t)/|u + t| moves by what is across it, and |u + t| = 1/(u·v).
        let moved = (along - now * now.dot(&along)) * before.dot(&now);
        let local = frames::tangents(&now);
        (0..2).map(|k| (of(axis, k), local[k].dot(&moved))).collect()
    }

    /// One in a channel, or ±1 by the position of a reversal; stacked.
    pub(super) fn level(&self, number: usize) -> Vec<f64> {
        let channel = &self.observed.channels[number];
        let position = self.observed.runs[channel.run].recording.column("position");
        let mut column = vec![0.0; self.observed.rows];
        for (at, row) in channel.range().zip(&channel.rows) {
            column[at] = position.map_or(1.0, |position| position[*row]);
        }
        column
    }

    pub(super) fn instrument(&self, run: usize) -> Instrument {
        instrument_of(&self.observed.runs[run])
    }

    /// The chain and the conditions of a run at a state.
    pub fn setting(&self, state: &State, run: usize) -> (Basic, Context<'a>) {
        let mut basic = self.observed.runs[run].setting.basic.clone();
        let mut context = self.observed.runs[run].setting.context.clone();
        let instrument = self.instrument(run);
        let mut turns = [[[0.0; 2]; 3]; 2];
        let mut rotation = Vector3::zeros();
        for (unknown, value) in self.unknowns.iter().zip(&state.base) {
            match unknown {
                Unknown::Chain(Parameter::SensorTurn(axis, which), of) if *of == instrument => {
                    turns[0][axis.index()][*which] = *value;
                }
                Unknown::Chain(Parameter::CoilTurn(axis, which), of) if *of == instrument => {
                    turns[1][axis.index()][*which] = *value;
                }
                Unknown::Chain(parameter, of) if *of == instrument => {
                    if let Some(place) = basic.constant_mut(*parameter) {
                        *place += value;
                    }
                }
                Unknown::Field(axis) if context.in_coils => {
                    context.ambient_nt.iter_mut().for_each(|field| field[axis.index()] += value);
                }
                Unknown::Turn { setting, about } if *setting == self.settings[run] => {
                    rotation[*about] = *value;
                }
                _ => {}
            }
        }
        for axis in Axis::ALL {
            let k = axis.index();
            if turns[0][k] != [0.0; 2] {
                let turned = frames::turned_at_length(&basic.mu.column(k).into_owned(), turns[0][k]);
                basic.mu.set_column(k, &turned);
            }
            if turns[1][k] != [0.0; 2] {
                let turned = frames::turned_at_length(&basic.eta.column(k).into_owned(), turns[1][k]);
                basic.eta.set_column(k, &turned);
            }
        }
        if rotation != Vector3::zeros() {
            context.orientation.rotation = frames::small_rotation(&rotation) * context.orientation.rotation;
        }
        if !self.observed.runs[run].smooth.is_empty() {
            context.ambient_nt = magnitude::ambient(&self.observed.runs[run], &basic, &context);
        }
        (basic, context)
    }
}

/// Whose constants a run shows.
pub(super) fn instrument_of(run: &Run<'_>) -> Instrument {
    if run.differential() { Instrument::Pair } else { Instrument::Read(run.setting.context.unit) }
}

/// The parameters of the chain.
fn chain() -> impl Iterator<Item = Parameter> {
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
