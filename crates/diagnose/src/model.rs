//! What is fitted: the calibration's parameters, what is not known of each recording, effects, and columns.

use common::{Axis, Document};
use estimate::screen::{Products, Screen};
use faer::Mat;
use nalgebra::Vector3;
use physics::{Basic, Context, EffectInstance, Kind, Parameter, Prediction, Role, Unit, frames};
use rayon::prelude::*;
use std::sync::Arc;

use crate::Error;
use crate::dependence::Follows;
use crate::magnitude;
use crate::observed::{Observed, Reader};

/// How well an offset of a sensor is known at least, nT. In one orientation it is one with the offset of the field, and only the sum
/// is determined: without this, part of it could be anything, and with temperature it would make any effect.
const OFFSET_NT: f64 = 1000.0;
/// Share of a column's squared length that is rounding.
const SAME: f64 = 1e-9;

/// Step of the differences by which turns of the block enter, rad.
const TURN_RAD: f64 = 1e-5;

/// A time constant or a level goes no farther beyond its plausible range than by this factor.
const FARTHEST: f64 = 10.0;

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
fn undetermined(columns: &[&Vec<f64>]) -> Result<Vec<usize>, Error> {
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

/// A column that is fitted beside the chain.
#[derive(Clone, Debug)]
pub struct Column {
    /// What it is, in words.
    pub what: String,
    /// What it follows; None for a single reading.
    pub follows: Option<Follows>,
    /// nT for each reading of the stack.
    pub values: Arc<Vec<f64>>,
    /// Its coefficient.
    pub coefficient: f64,
}

/// Where a fit stands.
#[derive(Clone, Debug)]
pub struct State {
    /// Of the unknowns of the base model: by how much they differ from the document.
    pub base: Vec<f64>,
    /// Effects that act: the document's, then those found.
    pub effects: Vec<EffectInstance>,
    /// In which recordings each acts.
    pub acts: Vec<Vec<bool>>,
    /// Columns.
    pub columns: Vec<Column>,
}

/// What is predicted of a run at a state.
struct Seen {
    basic: Basic,
    prediction: Prediction,
    /// By each parameter; None for those of an effect that does not act there.
    derivatives: Vec<Option<Prediction>>,
}

/// The recordings with what is unknown of them.
#[derive(Debug)]
pub struct Model<'a> {
    /// What was read.
    pub observed: Observed<'a>,
    /// The unknowns of the base model.
    pub unknowns: Vec<Unknown>,
    /// Their standard uncertainty, where they are known with one beforehand.
    pub priors: Vec<Option<f64>>,
    /// The setting of the block of each run.
    settings: Vec<usize>,
}

impl<'a> Model<'a> {
    /// The recordings of a document; unknown is of the base model what they can feel.
    pub fn of(document: &'a Document, observed: Observed<'a>) -> Result<(Self, State), Error> {
        let settings = settings(&observed);
        let mut all: Vec<(Unknown, Option<f64>)> = Vec::new();
        for instrument in [Instrument::Read(Unit::Volt), Instrument::Read(Unit::Nanotesla), Instrument::Pair]
        {
            all.extend(chain().map(|parameter| (Unknown::Chain(parameter, instrument), None)));
        }
        let axes = document.calibration.as_ref().and_then(|calibration| calibration.axes.as_ref());
        if axes.is_some_and(|axes| axes.residual_field_nt.is_some()) {
            all.extend(Axis::ALL.map(|axis| (Unknown::Field(axis), None)));
        }
        let channels = observed.channels.iter().enumerate();
        all.extend(
            channels
                .filter(|(_, c)| observed.runs[c.run].in_shield())
                .map(|(k, _)| (Unknown::Level(k), None)),
        );
        for setting in 0..settings.iter().max().map_or(0, |last| last + 1) {
            let run = settings.iter().position(|s| *s == setting).unwrap_or(0);
            let uncertain = observed.runs[run].setting.context.orientation.uncertainty.diagonal();
            for about in (0..3).filter(|about| uncertain[*about] > 0.0) {
                all.push((Unknown::Turn { setting, about }, Some(uncertain[about])));
            }
        }
        let (unknowns, priors) = all.into_iter().unzip();
        let mut model = Self { observed, unknowns, priors, settings };
        let effects = physics::adopt(document).map_err(|error| Error::Document(error.at("model")))?;
        let mut state = State {
            base: vec![0.0; model.unknowns.len()],
            effects: Vec::new(),
            acts: Vec::new(),
            columns: Vec::new(),
        };
        for effect in effects {
            state = model.with(&state, effect);
        }
        let jacobian = model.base_columns(&state)?;
        let mut felt: Vec<usize> =
            (0..model.unknowns.len()).filter(|k| jacobian[*k].iter().any(|value| *value != 0.0)).collect();
        if model.observed.channels.iter().all(|channel| channel.reader == Reader::Magnitude) {
            model.without_common_turn(&jacobian, &mut felt)?;
        }
        model.unknowns = felt.iter().map(|k| model.unknowns[*k]).collect();
        model.priors = felt.iter().map(|k| model.priors[*k]).collect();
        state.base = vec![0.0; felt.len()];
        let columns: Vec<&Vec<f64>> = felt.iter().map(|k| &jacobian[*k]).collect();
        for k in undetermined(&columns)? {
            if matches!(model.unknowns[k], Unknown::Chain(Parameter::SensorOffset(_), _)) {
                model.priors[k].get_or_insert(OFFSET_NT);
            }
        }
        Ok((model, state))
    }

    /// Takes turns of sensors out of the unknowns until none is said by the others, the last sensors' first: of magnitudes alone a turn
    /// of all sensors together shows nowhere.
    fn without_common_turn(&self, jacobian: &[Vec<f64>], felt: &mut Vec<usize>) -> Result<(), Error> {
        loop {
            let columns: Vec<&Vec<f64>> = felt.iter().map(|k| &jacobian[*k]).collect();
            let turns =
                |at: &usize| matches!(self.unknowns[felt[*at]], Unknown::Chain(Parameter::SensorTurn(..), _));
            let Some(last) = undetermined(&columns)?.into_iter().rfind(turns) else { return Ok(()) };
            felt.remove(last);
        }
    }

    /// A state with one effect more.
    pub fn with(&self, state: &State, effect: EffectInstance) -> State {
        let acts = self.acts(&effect);
        self.with_acting(state, effect, acts)
    }

    /// In which runs an effect acts, whatever its sizes and shapes.
    pub fn acts(&self, effect: &EffectInstance) -> Vec<bool> {
        (0..self.observed.runs.len()).map(|run| self.can_act(run, effect)).collect()
    }

    /// A state with one effect more, which acts in some runs.
    pub fn with_acting(&self, state: &State, effect: EffectInstance, acts: Vec<bool>) -> State {
        let mut next = state.clone();
        next.effects.push(effect);
        next.acts.push(acts);
        next
    }

    /// Whether an effect acts in a run: it belongs there, and all that it needs is recorded.
    pub fn can_act(&self, run: usize, effect: &EffectInstance) -> bool {
        let run = &self.observed.runs[run];
        let elsewhere = effect.recording.as_ref().is_some_and(|only| *only != run.recording.id);
        !elsewhere
            && effect.kind.acts_in(&run.recording.procedure)
            && physics::predict(&run.setting.basic, std::slice::from_ref(effect), &run.setting.context)
                .is_ok()
    }

    /// Parameters of a state's effects that are fitted: all that have a derivative.
    pub fn free(&self, state: &State) -> Vec<(usize, usize)> {
        let of = |(number, effect): (usize, &EffectInstance)| {
            let parameters = effect.kind.parameters().iter().enumerate();
            let smooth = parameters.filter(move |(_, info)| match effect.kind {
                Kind::Quantisation => false,
                Kind::VehiclePass => true,
                _ => info.role != Role::Epoch,
            });
            smooth.map(move |(parameter, _)| (number, parameter)).collect::<Vec<_>>()
        };
        state.effects.iter().enumerate().flat_map(of).collect()
    }

    /// What is known beforehand of the unknowns of a state: which of them, by how much it stands off, and its standard uncertainty.
    pub fn known(&self, state: &State) -> Vec<(usize, f64, f64)> {
        let base = self.priors.iter().zip(&state.base).enumerate();
        let base = base.filter_map(|(k, (prior, value))| prior.map(|std| (k, *value, std)));
        base.chain(self.known_of_effects(state)).collect()
    }

    /// The same of effects. Of a series of harmonics recordings determine only sums; each term is known to be of a plausible size.
    pub fn known_of_effects(&self, state: &State) -> Vec<(usize, f64, f64)> {
        let series = |(k, (effect, parameter)): (usize, (usize, usize))| {
            let effect = &state.effects[effect];
            let info = &effect.kind.parameters()[parameter];
            (effect.kind == Kind::SunThermoelectricHarmonics)
                .then(|| (self.unknowns.len() + k, effect.parameters[parameter], info.high))
        };
        self.free(state).into_iter().enumerate().filter_map(series).collect()
    }

    /// Observed less predicted, nT, over all channels.
    pub fn residual(&self, state: &State) -> Result<Vec<f64>, Error> {
        let parts: Vec<Vec<f64>> = (0..self.observed.runs.len())
            .into_par_iter()
            .map(|run| {
                let seen = self.predict(state, run, &[])?;
                let mut part = Vec::new();
                for channel in self.observed.channels_of(run) {
                    let predicted = channel.predicted(&seen.basic, &seen.prediction);
                    part.extend(channel.readings.iter().zip(predicted).map(|(y, p)| channel.to_nt * y - p));
                }
                Ok(part)
            })
            .collect::<Result<_, Error>>()?;
        let mut residual = parts.concat();
        for (number, unknown) in self.unknowns.iter().enumerate() {
            if let Unknown::Level(channel) = unknown {
                let level = state.base[number];
                let column = self.level(*channel);
                residual.iter_mut().zip(&column).for_each(|(r, c)| *r -= level * c);
            }
        }
        for column in &state.columns {
            residual.iter_mut().zip(column.values.iter()).for_each(|(r, c)| *r -= column.coefficient * c);
        }
        Ok(residual)
    }

    /// Derivatives of what is predicted by the unknowns at a state, base model, effects, columns. Shapes count by their logarithm.
    pub fn jacobian(&self, state: &State) -> Result<Vec<Vec<f64>>, Error> {
        let free = self.free(state);
        let parameters: Vec<Parameter> = free.iter().map(|(e, p)| Parameter::Effect(*e, *p)).collect();
        let mut columns = self.base_columns(state)?;
        let mut of_effects = self.derivatives(state, &parameters)?;
        for (column, (effect, parameter)) in of_effects.iter_mut().zip(&free) {
            let instance = &state.effects[*effect];
            if instance.kind.parameters()[*parameter].role == Role::Shape {
                let value = instance.parameters[*parameter];
                column.iter_mut().for_each(|d| *d *= value);
            }
        }
        columns.extend(of_effects);
        columns.extend(state.columns.iter().map(|column| column.values.to_vec()));
        Ok(columns)
    }

    /// A state moved along a step over the unknowns.
    pub fn advance(&self, state: &State, step: &[f64]) -> State {
        let mut next = state.clone();
        let base = self.unknowns.len();
        next.base.iter_mut().zip(step).for_each(|(value, s)| *value += s);
        let free = self.free(state);
        for ((effect, parameter), s) in free.iter().zip(&step[base..]) {
            let info = &next.effects[*effect].kind.parameters()[*parameter];
            let value = &mut next.effects[*effect].parameters[*parameter];
            if info.role == Role::Shape {
                let largest = if info.name == "frequency_hz" { 1e-2 } else { 1.0 };
                let moved = *value * s.clamp(-largest, largest).exp();
                *value = moved.clamp(info.low / FARTHEST, info.high * FARTHEST);
            } else {
                *value += s;
            }
        }
        for (column, s) in next.columns.iter_mut().zip(&step[base + free.len()..]) {
            column.coefficient += s;
        }
        next
    }

    /// Derivatives of what is predicted by parameters of effects, stacked.
    pub fn derivatives(&self, state: &State, parameters: &[Parameter]) -> Result<Vec<Vec<f64>>, Error> {
        let parts: Vec<Vec<Vec<f64>>> = (0..self.observed.runs.len())
            .into_par_iter()
            .map(|run| {
                let Seen { basic, prediction, derivatives } = self.predict(state, run, parameters)?;
                let stack = |derivative: &Option<Prediction>| {
                    let mut part = Vec::new();
                    for channel in self.observed.channels_of(run) {
                        match derivative {
                            Some(derivative) => {
                                part.extend(channel.derivative(&basic, &prediction, derivative));
                            }
                            None => part.extend(std::iter::repeat_n(0.0, channel.rows.len())),
                        }
                    }
                    part
                };
                Ok(derivatives.iter().map(stack).collect())
            })
            .collect::<Result<_, Error>>()?;
        Ok((0..parameters.len())
            .map(|k| parts.iter().flat_map(|part| part[k].iter().copied()).collect())
            .collect())
    }

    /// What is predicted, nT, stacked.
    pub fn predicted(&self, state: &State) -> Result<Vec<f64>, Error> {
        let parts: Vec<Vec<f64>> = (0..self.observed.runs.len())
            .into_par_iter()
            .map(|run| {
                let seen = self.predict(state, run, &[])?;
                let channels = self.observed.channels_of(run);
                Ok(channels.flat_map(|channel| channel.predicted(&seen.basic, &seen.prediction)).collect())
            })
            .collect::<Result<_, Error>>()?;
        Ok(parts.concat())
    }

    /// What is predicted with one effect more, less what is predicted without, stacked.
    pub fn contribution(&self, state: &State, effect: &EffectInstance) -> Result<Vec<f64>, Error> {
        self.change(state, &self.with(state, effect.clone()))
    }

    /// By how much what is predicted changes from one state to another, stacked.
    pub fn change(&self, from: &State, to: &State) -> Result<Vec<f64>, Error> {
        let (before, after) = (self.residual(from)?, self.residual(to)?);
        Ok(before.iter().zip(after).map(|(a, b)| a - b).collect())
    }

    fn base_columns(&self, state: &State) -> Result<Vec<Vec<f64>>, Error> {
        let parameters: Vec<Parameter> = chain().collect();
        let runs: Vec<Vec<Vec<f64>>> = (0..self.observed.runs.len())
            .into_par_iter()
            .map(|run| {
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

    /// What moves when a parameter of the chain moves. A turn counts along the tangents of the direction as the document has it; the
    /// chain's derivatives are along those of the direction as it stands.
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
    fn level(&self, number: usize) -> Vec<f64> {
        let channel = &self.observed.channels[number];
        let position = self.observed.runs[channel.run].recording.column("position");
        let mut column = vec![0.0; self.observed.rows];
        for (at, row) in channel.range().zip(&channel.rows) {
            column[at] = position.map_or(1.0, |position| position[*row]);
        }
        column
    }

    fn instrument(&self, run: usize) -> Instrument {
        let run = &self.observed.runs[run];
        if run.differential() { Instrument::Pair } else { Instrument::Read(run.setting.context.unit) }
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
                    if let Some(place) = place(&mut basic, *parameter) {
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
                let turned = turned(&basic.mu.column(k).into_owned(), turns[0][k]);
                basic.mu.set_column(k, &turned);
            }
            if turns[1][k] != [0.0; 2] {
                let turned = turned(&basic.eta.column(k).into_owned(), turns[1][k]);
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

    /// Prediction of a run at a state, and its derivatives.
    fn predict(&self, state: &State, run: usize, parameters: &[Parameter]) -> Result<Seen, Error> {
        let (basic, context) = self.setting(state, run);
        let acting: Vec<usize> = (0..state.effects.len()).filter(|k| state.acts[*k][run]).collect();
        let effects: Vec<EffectInstance> = acting.iter().map(|k| state.effects[*k].clone()).collect();
        let mapped: Vec<Option<Parameter>> = parameters
            .iter()
            .map(|parameter| match parameter {
                Parameter::Effect(effect, number) => {
                    let at = acting.iter().position(|k| k == effect)?;
                    Some(Parameter::Effect(at, *number))
                }
                other => Some(*other),
            })
            .collect();
        let wanted: Vec<Parameter> = mapped.iter().flatten().copied().collect();
        let failed = |error: physics::Error| Error::Document(error.at(&self.observed.runs[run].path));
        let (prediction, found) =
            physics::predict_with_jacobian(&basic, &effects, &context, &wanted).map_err(failed)?;
        let mut found = found.into_iter();
        let derivatives = mapped.iter().map(|m| m.as_ref().and_then(|_| found.next())).collect();
        Ok(Seen { basic, prediction, derivatives })
    }

    /// Whether any channel is of a sensor, or of all together.
    pub fn reads(&self, axis: Axis) -> bool {
        let of = |reader: Reader| [Reader::Sensor(axis), Reader::Magnitude].contains(&reader);
        self.observed.channels.iter().any(|channel| of(channel.reader))
    }

    /// Whether a coil is driven in any recording.
    pub fn drives(&self, axis: Axis) -> bool {
        let driven = |current: &Vector3<f64>| current[axis.index()].abs() > 0.0;
        self.observed.runs.iter().any(|run| run.setting.context.current_a.iter().any(driven))
    }
}

/// A direction turned as [`frames::turned`] does, its length kept: columns of η of two magnetometers are no unit vectors.
fn turned(direction: &Vector3<f64>, turn: [f64; 2]) -> Vector3<f64> {
    frames::turned(&direction.normalize(), turn) * direction.norm()
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

/// Where a constant of the chain stands.
fn place(basic: &mut Basic, parameter: Parameter) -> Option<&mut f64> {
    match parameter {
        Parameter::Sensitivity(axis) => Some(&mut basic.sensors[axis.index()].sensitivity),
        Parameter::SensorOffset(axis) => Some(&mut basic.sensors[axis.index()].offset_nt),
        Parameter::CoilConstant(axis) => Some(&mut basic.coils[axis.index()].constant_nt_per_a),
        Parameter::CoilOffset(axis) => Some(&mut basic.coils[axis.index()].offset_nt),
        _ => None,
    }
}

/// The setting of the block of each run: recordings of one orientation share it, unless they name it otherwise.
fn settings(observed: &Observed<'_>) -> Vec<usize> {
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
