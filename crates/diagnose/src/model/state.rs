//! The recordings with what is unknown of them, and where a fit stands; and what effects that follow the field outside kept
//! of the time before the recordings.

use common::Axis;
use nalgebra::Vector3;
use physics::{EffectInstance, Family, Kind, ParameterInfo, Role, Unit};
use std::collections::BTreeMap;
use std::sync::Mutex;

use super::unknown::Unknown;
use crate::Error;
use crate::algebra::square;
use crate::channel::Reader;
use crate::observed::Observed;

/// A single reading that is off by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Single {
    pub what: String,
    /// Its row in the stack of all channels.
    pub row: usize,
    /// By how much it is off, nT.
    pub height_nt: f64,
}

/// What an effect that follows the field outside kept, in one channel, of the time before the recording, which nobody
/// recorded: it dies with the effect's time constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Past {
    pub effect: usize,
    pub relaxation: usize,
    pub channel: usize,
    /// Its size in the first row, nT.
    pub height_nt: f64,
    /// Standard deviation of that beforehand: what the effect does in the channel.
    pub std_nt: f64,
}

#[derive(Clone, Debug, Default)]
pub struct State {
    /// Of the unknowns of the base model: by how much they differ from the document.
    pub base: Vec<f64>,
    /// Effects that act: the document's, then those found.
    pub effects: Vec<EffectInstance>,
    pub acts: Vec<Vec<bool>>,
    pub singles: Vec<Single>,
    /// What is left of the time before the recordings.
    pub past: Vec<Past>,
}

impl State {
    /// Keeps some of its effects, by their number, and what belongs to them.
    pub fn keep_effects(&mut self, keeps: impl Fn(usize) -> bool) {
        let kept: Vec<usize> = (0..self.effects.len()).filter(|number| keeps(*number)).collect();
        self.effects = kept.iter().map(|number| self.effects[*number].clone()).collect();
        self.acts = kept.iter().map(|number| self.acts[*number].clone()).collect();
        let moved = |past: &Past| {
            let effect = kept.iter().position(|number| *number == past.effect)?;
            Some(Past { effect, ..past.clone() })
        };
        self.past = self.past.iter().filter_map(moved).collect();
    }
}

#[derive(Debug)]
pub struct Model<'a> {
    pub observed: Observed<'a>,
    pub unknowns: Vec<Unknown>,
    /// Their standard uncertainty, where they are known with one beforehand.
    pub priors: Vec<Option<f64>>,
    pub(super) settings: Vec<usize>,
    /// Which effects can act in which runs, as far as that was asked.
    pub(super) acting: Mutex<BTreeMap<(usize, String), bool>>,
}

impl Model<'_> {
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
        let (number, run) = (run, &self.observed.runs[run]);
        let elsewhere = effect.recording.as_ref().is_some_and(|only| *only != run.recording.id);
        if elsewhere || !effect.kind.acts_in(&run.recording.procedure) {
            return false;
        }
        let key = (number, named(effect));
        if let Some(known) = self.acting.lock().ok().and_then(|acting| acting.get(&key).copied()) {
            return known;
        }
        let can = physics::predict(&run.setting.basic, std::slice::from_ref(effect), &run.setting.context);
        if let Ok(mut acting) = self.acting.lock() {
            acting.insert(key, can.is_ok());
        }
        can.is_ok()
    }

    /// Parameters of a state's effects that are fitted: all that have a derivative.
    pub fn free(&self, state: &State) -> Vec<(usize, usize)> {
        let of = |(number, effect): (usize, &EffectInstance)| {
            let parameters = effect.kind.parameters().iter().enumerate();
            let smooth = parameters.filter(move |(number, info)| match (effect.kind, info.role) {
                (Kind::Quantisation, _) => false,
                (Kind::VehiclePass, _) | (_, Role::Amplitude) => true,
                _ => info.is_shape_at(effect.parameters[*number]),
            });
            smooth.map(move |(parameter, _)| (number, parameter)).collect::<Vec<_>>()
        };
        state.effects.iter().enumerate().flat_map(of).collect()
    }

    /// What is known beforehand: which unknown, by how much it stands off, and its standard uncertainty.
    pub fn known(&self, state: &State) -> Vec<(usize, f64, f64)> {
        let base = self.priors.iter().zip(&state.base).enumerate();
        let base = base.filter_map(|(k, (prior, value))| prior.map(|std| (k, *value, std)));
        let past = self.unknowns.len() + self.free(state).len() + state.singles.len();
        let past = state.past.iter().enumerate().map(|(k, one)| (past + k, one.height_nt, one.std_nt));
        base.chain(self.known_of_effects(state)).chain(past).collect()
    }

    /// The same of effects. Of a series of harmonics recordings determine only sums, and of two short lags their sum;
    /// each term and their ratio are known to be of a plausible size.
    pub fn known_of_effects(&self, state: &State) -> Vec<(usize, f64, f64)> {
        let known = |(k, (effect, parameter)): (usize, (usize, usize))| {
            let effect = &state.effects[effect];
            let (info, value) = (&effect.kind.parameters()[parameter], effect.parameters[parameter]);
            let (off, std) = match (effect.kind, info.name.ends_with("_ratio")) {
                (Kind::SunThermoelectricHarmonics, _) => (value, info.high),
                (_, true) => ((value / info.middle()).ln(), 0.25 * (info.high / info.low).ln()),
                _ => return None,
            };
            Some((self.unknowns.len() + k, off, std))
        };
        self.free(state).into_iter().enumerate().filter_map(known).collect()
    }

    /// The unit of a run's readings, which says whose constants it shows.
    pub(super) fn unit(&self, run: usize) -> Unit {
        self.observed.runs[run].setting.context.unit
    }

    pub fn reads(&self, axis: Axis) -> bool {
        let of = |reader: Reader| [Reader::Sensor(axis), Reader::Magnitude].contains(&reader);
        self.observed.channels.iter().any(|channel| of(channel.reader))
    }

    pub fn only_magnitudes(&self) -> bool {
        self.observed.channels.iter().all(|channel| channel.reader == Reader::Magnitude)
    }

    pub fn drives(&self, axis: Axis) -> bool {
        let driven = |current: &Vector3<f64>| current[axis.index()].abs() > 0.0;
        self.observed.runs.iter().any(|run| run.setting.context.current_a.iter().any(driven))
    }
}

/// An effect with what it acts on.
pub fn named(effect: &EffectInstance) -> String {
    let name = effect.kind.name();
    target(effect).map_or_else(|| name.to_string(), |target| format!("{name} {target}"))
}

/// What an effect acts on.
pub fn target(effect: &EffectInstance) -> Option<String> {
    effect.axis.map(|axis| axis.to_string()).or_else(|| effect.column.clone())
}

/// The numbers of the parameters of an effect that are amplitudes; none where its size is its shape.
pub fn amplitudes(kind: Kind) -> Vec<usize> {
    let infos = kind.parameters();
    (0..infos.len()).filter(|k| infos[*k].role == Role::Amplitude).collect()
}

impl Model<'_> {
    /// A state with the past of its effects from one on, unknown and as large as what they do.
    pub fn with_past(&self, mut state: State, from: usize) -> Result<State, Error> {
        for effect in from..state.effects.len() {
            let relaxations = time_constants_s(&state.effects[effect]).len();
            if relaxations == 0 {
                continue;
            }
            let mut without = state.clone();
            without.acts[effect].fill(false);
            let does = self.change(&without, &state)?;
            for (channel, of) in self.observed.channels.iter().enumerate() {
                let std_nt = (square(&does[of.range()]) / of.rows.len() as f64).sqrt();
                let past = |relaxation| Past { effect, relaxation, channel, height_nt: 0.0, std_nt };
                state.past.extend((0..relaxations).filter(|_| std_nt > 0.0).map(past));
            }
        }
        Ok(state)
    }

    /// What one nT of it does, stacked.
    pub(super) fn past(&self, state: &State, past: &Past) -> Vec<f64> {
        let mut column = vec![0.0; self.observed.rows];
        let channel = &self.observed.channels[past.channel];
        let time = self.observed.runs[channel.run].time_s;
        let taus = time_constants_s(&state.effects[past.effect]);
        if let (Some(time), Some(tau)) = (time, taus.get(past.relaxation)) {
            for (at, row) in channel.range().zip(&channel.rows) {
                column[at] = ((time[0] - time[*row]) / tau).exp();
            }
        }
        column
    }
}

/// Which parameter is the time constant of an effect that remembers fields. One that remembers temperatures has none
/// here: they are let settle before a recording.
pub fn time_constant(kind: Kind) -> Option<usize> {
    let about = kind.about();
    let remembers = matches!(about.family, Family::LateResponse | Family::OutsideField);
    let is_it = |info: &ParameterInfo| ["lag_s", "time_constant_s"].contains(&info.name);
    about.parameters.iter().position(is_it).filter(|_| remembers)
}

/// The time constants of an effect of the field outside, which was there before; drives were at rest.
fn time_constants_s(effect: &EffectInstance) -> Vec<f64> {
    let infos = effect.kind.parameters();
    let place = time_constant(effect.kind).filter(|_| effect.kind.follows_outside());
    let second = infos.iter().position(|info| info.name == "second_lag_ratio");
    let Some(tau) = place.map(|place| effect.parameters[place]) else { return Vec::new() };
    let second = second.map(|place| effect.parameters[place] * tau).filter(|tau| *tau > 0.0);
    std::iter::once(tau).chain(second).collect()
}
