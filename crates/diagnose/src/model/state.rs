//! The recordings with what is unknown of them, and where a fit stands.

use common::Axis;
use nalgebra::Vector3;
use physics::{EffectInstance, Kind, Role, Unit};
use std::collections::BTreeMap;
use std::sync::Mutex;

use super::unknown::Unknown;
use crate::channel::Reader;
use crate::observed::Observed;
use crate::what::named;

/// A single reading that is off by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Single {
    /// What it is, in words.
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
    /// Number of the effect.
    pub effect: usize,
    /// Which of its relaxations.
    pub relaxation: usize,
    /// Number of the channel.
    pub channel: usize,
    /// Its size in the first row, nT.
    pub height_nt: f64,
    /// Standard deviation of that beforehand: what the effect does in the channel.
    pub std_nt: f64,
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
    /// Single readings.
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
    pub(super) settings: Vec<usize>,
    /// Which effects can act in which runs, as far as that was asked.
    pub(super) acting: Mutex<BTreeMap<(usize, String), bool>>,
}

impl Model<'_> {
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

    /// What is known beforehand of the unknowns of a state: which of them, by how much it stands off, and its
    /// standard uncertainty.
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
