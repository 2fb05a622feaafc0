//! What is fitted: the calibration's parameters, what is not known of each recording, effects, and columns.

mod basic;
mod known;
mod step;

pub use basic::{Instrument, Unknown};
pub use known::stated_std;

use common::{Axis, Document};
use nalgebra::Vector3;
use physics::{Basic, EffectInstance, Kind, Parameter, Prediction, Role};
use rayon::prelude::*;
use std::sync::Arc;

use crate::Error;
use crate::channel::Reader;
use crate::observed::Observed;
use basic::{OFFSET_NT, possible, settings, undetermined};

/// A time constant or a level goes no farther beyond its plausible range than by this factor.
const FARTHEST: f64 = 10.0;

/// What a column of a fit follows.
#[derive(Clone, Debug)]
pub struct Follows {
    /// The recorded column.
    pub column: String,
    /// The sensor that follows it.
    pub axis: Axis,
    /// Time constant of the first-order lag, s.
    pub lag_s: f64,
    /// Its standard uncertainty, s: half the width over which the gain is less than one below its most.
    pub lag_std_s: Option<f64>,
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
    /// Where they are known to be, as shifts from the document.
    pub centres: Vec<f64>,
    /// The setting of the block of each run.
    settings: Vec<usize>,
}

impl<'a> Model<'a> {
    /// The recordings of a document; unknown is of the base model what they can feel.
    pub fn of(document: &'a Document, observed: Observed<'a>) -> Result<(Self, State), Error> {
        let settings = settings(&observed);
        let (unknowns, priors) = possible(document, &observed, &settings).into_iter().unzip();
        let mut model = Self { observed, unknowns, priors, centres: Vec::new(), settings };
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
        if model.only_magnitudes() {
            model.without_common_turn(&mut felt);
        }
        model.unknowns = felt.iter().map(|k| model.unknowns[*k]).collect();
        model.priors = felt.iter().map(|k| model.priors[*k]).collect();
        state.base = vec![0.0; felt.len()];
        model.centres = vec![0.0; felt.len()];
        let columns: Vec<&Vec<f64>> = felt.iter().map(|k| &jacobian[*k]).collect();
        for k in undetermined(&columns)? {
            if matches!(model.unknowns[k], Unknown::Chain(Parameter::SensorOffset(_), _)) {
                model.priors[k].get_or_insert(OFFSET_NT);
            }
        }
        Ok((model, state))
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

    /// What is known beforehand of the unknowns of a state: which of them, by how much it stands off, and its
    /// standard uncertainty.
    pub fn known(&self, state: &State) -> Vec<(usize, f64, f64)> {
        let base = self.priors.iter().zip(&self.centres).zip(&state.base).enumerate();
        let base = base.filter_map(|(k, ((prior, centre), value))| prior.map(|std| (k, value - centre, std)));
        base.chain(self.known_of_effects(state)).collect()
    }

    /// The same of effects. Of a series of harmonics recordings determine only sums; each term is known to be
    /// of a plausible size.
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

    /// Derivatives of what is predicted by the unknowns behind those of the base model at a state: effects,
    /// columns. Shapes count by their logarithm.
    pub fn other_columns(&self, state: &State) -> Result<Vec<Vec<f64>>, Error> {
        let free = self.free(state);
        let parameters: Vec<Parameter> = free.iter().map(|(e, p)| Parameter::Effect(*e, *p)).collect();
        let mut of_effects = self.derivatives(state, &parameters)?;
        for (column, (effect, parameter)) in of_effects.iter_mut().zip(&free) {
            let instance = &state.effects[*effect];
            if instance.kind.parameters()[*parameter].role == Role::Shape {
                let value = instance.parameters[*parameter];
                column.iter_mut().for_each(|d| *d *= value);
            }
        }
        of_effects.extend(state.columns.iter().map(|column| column.values.to_vec()));
        Ok(of_effects)
    }

    /// A state moved along a step over the unknowns.
    pub fn advance(&self, state: &State, step: &[f64]) -> State {
        let mut next = state.clone();
        let base = self.unknowns.len();
        next.base.iter_mut().zip(step).for_each(|(value, s)| *value += s);
        self.straighten(state, &mut next);
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

    /// Columns of the last effect of a state: the derivatives by its amplitudes, or, of an effect that has
    /// none, by how much it changes what a state without it predicts, and whether it is that.
    pub fn columns_of_last(&self, without: &State, with: &State) -> Result<(Vec<Vec<f64>>, bool), Error> {
        let number = with.effects.len() - 1;
        let infos = with.effects[number].kind.parameters().iter().enumerate();
        let amplitudes: Vec<Parameter> = infos
            .filter(|(_, info)| info.role == Role::Amplitude)
            .map(|(k, _)| Parameter::Effect(number, k))
            .collect();
        if amplitudes.is_empty() {
            return Ok((vec![self.change(without, with)?], true));
        }
        Ok((self.derivatives(with, &amplitudes)?, false))
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

    /// By how much what is predicted changes from one state to another, stacked.
    pub fn change(&self, from: &State, to: &State) -> Result<Vec<f64>, Error> {
        let (before, after) = (self.residual(from)?, self.residual(to)?);
        Ok(before.iter().zip(after).map(|(a, b)| a - b).collect())
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

    /// Whether nothing was read but magnitudes.
    pub fn only_magnitudes(&self) -> bool {
        self.observed.channels.iter().all(|channel| channel.reader == Reader::Magnitude)
    }

    /// Whether a coil is driven in any recording.
    pub fn drives(&self, axis: Axis) -> bool {
        let driven = |current: &Vector3<f64>| current[axis.index()].abs() > 0.0;
        self.observed.runs.iter().any(|run| run.setting.context.current_a.iter().any(driven))
    }
}
