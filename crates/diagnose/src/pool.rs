//! What could have been left out: every effect of the catalogue on everything that it can act on, with its
//! shapes.

use common::Axis;
use physics::{Acts, EffectInstance, KELVIN, Kind, ParameterInfo, Role, Thermometer};
use rayon::prelude::*;
use std::borrow::Cow;

use crate::Error;
use crate::candidates::{Candidate, Kept, Shape};
use crate::channel::Run;
use crate::generic;
use crate::model::{Model, State, amplitudes};
use crate::proposal::{Addition, Proposal, What};
use crate::stacked::Stacked;

/// Shapes that are tried: each so many times the one before, at most.
const RATIO: f64 = 2.5;
/// The same for effects without amplitude, whose size is their shape, to a power of five to nine for saturation:
/// from one trial to the next it grows by less than the range in which a coefficient is about one.
const FINE_RATIO: f64 = 1.25;
/// Most shapes of a candidate.
const SHAPES: usize = 16;
/// Inflections that are tried over the range of a temperature.
const INFLECTIONS: usize = 9;
/// Levels of clipping that are tried.
const CLIPS: i32 = 14;
/// The parameter by which what depends on the past begins: demagnetised, or at rest in the first field.
const START: &str = "start_share";
/// Most steps into which a span is divided.
const SPAN_STEPS: f64 = 60.0;
/// A time constant of this share of a step is far less than one; from there on each so many times the one before.
const BRIEF: f64 = 1e-3;
const BRIEF_RATIO: f64 = 5.0;
/// A time constant of more spans than these is a straight line.
const SPANS: f64 = 3.0;

/// Candidates and their columns, nT, stacked.
#[derive(Clone, Debug, Default)]
pub struct Pool {
    pub candidates: Vec<Candidate>,
    pub columns: Vec<Stacked>,
    pub without: Vec<Kind>,
}

impl Pool {
    /// All that can act, some effects apart. What was screened out keeps its number, without a shape.
    pub fn of(
        model: &Model<'_>,
        state: &State,
        without: &[Kind],
        kept: Option<&Kept>,
    ) -> Result<Self, Error> {
        let scale = Scale::of(model);
        let mut templates = templates(model, state);
        templates.retain(|effect| !is_of(effect, without));
        let tried = |effect: &EffectInstance| match kept {
            Some(kept) => kept.shapes_of(&What::Physics(effect.clone())),
            None => shapes(effect, &scale),
        };
        let made = templates.par_iter().map(|effect| make(model, state, effect, tried(effect)));
        let made: Vec<Option<Made>> = made.collect::<Result<_, Error>>()?;
        let mut pool = Pool { without: without.to_vec(), ..Self::default() };
        for (effect, made) in templates.into_iter().zip(made) {
            if let Some((finite, trials)) = made {
                pool.push(What::Physics(effect), finite, trials);
            }
        }
        let names = kept.map(Kept::names);
        for (what, trials) in generic::all(model, state, names.as_ref())? {
            let key = (what.name(), trials.first().is_some_and(|(shape, _)| shape.is_some()));
            let is_kept = |number: usize| kept.is_none_or(|kept| kept.keeps(&key, number));
            let trials = trials.into_iter().enumerate().filter(|(number, _)| is_kept(*number));
            let trials = trials.map(|(_, (shape, columns))| (shape, None, columns));
            pool.push(what, false, trials.collect());
        }
        if let Some(kept) = kept {
            pool.candidates = kept.numbered(pool.candidates);
        }
        Ok(pool)
    }

    /// Whether something that was found by itself is considered.
    pub fn considers(&self, proposal: &Proposal) -> bool {
        match &proposal.addition {
            Addition::Effect(effect) => !is_of(effect, &self.without),
            Addition::Single(_) => true,
        }
    }

    /// For each column the first of its trial.
    pub fn groups(&self) -> Vec<usize> {
        let shapes = self.candidates.iter().flat_map(|candidate| &candidate.shapes);
        shapes.flat_map(|shape| shape.columns.iter().map(|_| shape.columns[0])).collect()
    }

    fn push(&mut self, what: What, finite: bool, trials: Vec<Tried>) {
        let mut shapes = Vec::new();
        for (value, form, columns) in trials {
            if columns.iter().all(Stacked::is_finite) && !columns.iter().all(Stacked::is_zero) {
                let at = self.columns.len();
                self.columns.extend(columns);
                let columns = (at..self.columns.len()).collect();
                shapes.push(Shape { value, form, columns, by_shape: Vec::new() });
            }
        }
        if !shapes.is_empty() {
            self.candidates.push(Candidate { what, finite, tried: shapes.len(), shapes });
        }
    }
}

/// Whether an effect is one of some kinds, or a fuller form of one.
fn is_of(effect: &EffectInstance, kinds: &[Kind]) -> bool {
    [Some(effect.kind), effect.simpler()].into_iter().flatten().any(|kind| kinds.contains(&kind))
}

/// A shape, the fuller form that has it, and its columns.
type Tried = (Option<f64>, Option<EffectInstance>, Vec<Stacked>);
/// Whether the columns are what the effect does, and the columns of each shape.
type Made = (bool, Vec<Tried>);

/// What times and signals span.
struct Scale {
    /// Shortest time from one row to the next, s.
    step_s: f64,
    /// Smallest and largest time constant that could show, s.
    lag_s: [f64; 2],
    /// Largest reading, nT.
    reading_nt: f64,
    /// Range of the readings, nT.
    range_nt: f64,
    /// Coldest and warmest sensor, K.
    sensor_k: [f64; 2],
}

impl Scale {
    fn of(model: &Model<'_>) -> Self {
        let (mut step, mut span) = (f64::INFINITY, 0.0_f64);
        for time in model.observed.runs.iter().filter_map(|run| run.time_s) {
            let mut steps: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).filter(|s| *s > 0.0).collect();
            steps.sort_by(f64::total_cmp);
            if let Some(middle) = steps.get(steps.len() / 2) {
                step = step.min(*middle);
                span = span.max(time[time.len() - 1] - time[0]);
            }
        }
        let channels = model.observed.channels.iter();
        let readings = channels.flat_map(|channel| channel.readings.iter().map(|y| y * channel.to_nt));
        let (low, high) = readings.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| (l.min(r), h.max(r)));
        let sensor =
            |run: &Run<'_>| run.setting.context.optional(Thermometer::Sensor.column()).map(Cow::into_owned);
        let warmth: Vec<f64> = model.observed.runs.iter().filter_map(sensor).flatten().collect();
        Self {
            step_s: step,
            lag_s: [0.3 * step, SPANS * span],
            reading_nt: high.abs().max(low.abs()),
            range_nt: high - low,
            sensor_k: [
                warmth.iter().copied().fold(f64::INFINITY, f64::min) + KELVIN,
                warmth.iter().copied().fold(f64::NEG_INFINITY, f64::max) + KELVIN,
            ],
        }
    }

    /// Values of a shape that could show.
    fn grid(&self, kind: Kind, info: &ParameterInfo) -> Vec<f64> {
        if kind == Kind::OffsetTemperatureInflection {
            let [coldest, warmest] = self.sensor_k;
            let at = |k: usize| coldest + (warmest - coldest) * k as f64 / (INFLECTIONS + 1) as f64;
            return if coldest < warmest { (1..=INFLECTIONS).map(at).collect() } else { Vec::new() };
        }
        if kind == Kind::Clipping {
            // A level just below the largest reading cuts off few of them.
            let level = |k: i32| self.reading_nt * (1.0 - 0.5_f64.powi(k + 1));
            return (0..CLIPS).map(level).filter(|level| *level > info.low).collect();
        }
        let (mut low, mut high) = (info.low, info.high);
        if info.name.ends_with("_s") {
            (low, high) = (low.max(self.lag_s[0]), high.min(self.lag_s[1]));
        } else if kind == Kind::Saturation {
            // A level far beyond the readings does nothing.
            (low, high) = (low.max(0.3 * self.reading_nt), high.min(2.5 * self.reading_nt));
        } else if info.name.ends_with("_nt") {
            high = high.min(self.range_nt);
        }
        if !(low > 0.0 && low < high && high.is_finite()) {
            return info.absent.into_iter().collect();
        }
        if info.role == Role::Epoch {
            let step = self.step_s.max(info.high / SPAN_STEPS);
            return (0..=(info.high / step) as usize).map(|k| k as f64 * step).collect();
        }
        let sized = !amplitudes(kind).is_empty();
        let ratio = if sized { RATIO } else { FINE_RATIO };
        let count = ((high / low).ln() / ratio.ln()).ceil().clamp(1.0, (SHAPES - 1) as f64);
        let grid = (0..=count as usize).map(|k| low * (high / low).powf(k as f64 / count));
        // What is late by less than a step does as much as it is late.
        let least = info.low.max(BRIEF * self.step_s);
        let brief = std::iter::successors(Some(least), |value| Some(value * BRIEF_RATIO));
        let brief = brief.take_while(|value| !sized && info.name.ends_with("_s") && *value < low);
        brief.chain(grid).collect()
    }
}

/// The parameter of an effect that goes through a grid: its first shape, or a span that may be nothing.
pub fn searched(kind: Kind) -> Option<usize> {
    let goes = |info: &ParameterInfo| match info.role {
        Role::Amplitude => false,
        Role::Shape => true,
        Role::Epoch => !info.is_moment(),
    };
    kind.parameters().iter().position(goes)
}

/// Every effect on everything that it can act on, amplitudes zero.
fn templates(model: &Model<'_>, state: &State) -> Vec<EffectInstance> {
    let mut all = Vec::new();
    for &kind in Kind::ALL {
        // Lines, events and codes are searched by themselves, and what has no name is none.
        let apart = |info: &ParameterInfo| info.is_moment() || info.name == "frequency_hz";
        let apart = kind.parameters().iter().any(apart);
        if apart || matches!(kind, Kind::Quantisation | Kind::DifferentialNonlinearity) {
            continue;
        }
        let one = |axis: Option<Axis>, column: Option<String>| {
            // Shapes beside the first, which goes through its grid, begin in the middle of what is plausible; those that
            // a document need not give, at their absence.
            let value = |info: &ParameterInfo| match info.role {
                Role::Shape => info.absent.unwrap_or_else(|| info.middle()),
                _ if info.name == "reference" => {
                    column.as_ref().map_or(0.0, |name| model.observed.mean(name))
                }
                _ => 0.0,
            };
            let parameters = kind.parameters().iter().map(value).collect();
            EffectInstance { column, ..EffectInstance::new(kind, axis, parameters) }
        };
        match kind.about().acts {
            Acts::OneSensor => {
                all.extend(Axis::ALL.into_iter().filter(|a| model.reads(*a)).map(|a| one(Some(a), None)));
            }
            Acts::OneCoil => {
                all.extend(Axis::ALL.into_iter().filter(|a| model.drives(*a)).map(|a| one(Some(a), None)));
            }
            Acts::Everything => {
                all.push(one(None, None));
                // A clock may be set anew for each recording.
                let timed = model.observed.runs.iter().filter(|run| run.time_s.is_some());
                let recordings = timed.map(|run| Some(run.recording.id.clone()));
                let recordings: Vec<_> = recordings.filter(|_| kind == Kind::ClockOffset).collect();
                if recordings.len() > 1 {
                    let in_one = |recording| EffectInstance { recording, ..one(None, None) };
                    all.extend(recordings.into_iter().map(in_one));
                }
            }
            Acts::WithColumn(_) => {
                let columns = model.observed.columns().into_iter().filter(|name| kind.takes(name));
                all.extend(columns.map(|name| one(None, Some(name))));
            }
        }
    }
    let there = |effect: &EffectInstance| {
        let same = |other: &EffectInstance| other.kind == effect.kind && other.target() == effect.target();
        state.effects.iter().any(same)
    };
    all.retain(|effect| !there(effect));
    all
}

/// An effect in its fuller form: with a start at rest in the first field, or with a shape that it need not have, such
/// as a second relaxation. None where it has that already.
pub fn fuller(effect: &EffectInstance) -> Option<EffectInstance> {
    let infos = effect.kind.parameters();
    let more = (0..infos.len()).find(|k| {
        let second = infos[*k].role == Role::Shape && Some(*k) != searched(effect.kind);
        infos[*k].absent == Some(effect.parameters[*k]) && (second || infos[*k].name == START)
    })?;
    let mut effect = effect.clone();
    effect.parameters[more] = if infos[more].name == START { 1.0 } else { infos[more].middle() };
    Some(effect)
}

/// An effect as the simpler one that it is a fuller form of, with the parameters that both have.
pub fn simpler(effect: &EffectInstance) -> Option<EffectInstance> {
    let kind = effect.simpler()?;
    let value = |info: &ParameterInfo| {
        let place = effect.kind.parameters().iter().position(|own| own.name == info.name);
        place.map_or(info.absent.unwrap_or_else(|| info.middle()), |place| effect.parameters[place])
    };
    let parameters = kind.parameters().iter().map(value).collect();
    Some(EffectInstance { kind, parameters, ..effect.clone() })
}

/// The shapes that are tried of an effect, and of its fuller form.
fn shapes(template: &EffectInstance, scale: &Scale) -> Vec<(Option<f64>, Option<EffectInstance>)> {
    let infos = template.kind.parameters();
    let grid: Vec<Option<f64>> = match searched(template.kind) {
        Some(at) => {
            // Without the lag it may be an effect of another name.
            let absent =
                infos[at].absent.filter(|_| infos[at].role == Role::Shape && template.simpler().is_none());
            let grid = scale.grid(template.kind, &infos[at]).into_iter();
            absent.into_iter().chain(grid.filter(|value| absent != Some(*value))).map(Some).collect()
        }
        None => vec![None],
    };
    let forms = std::iter::once(None).chain(fuller(template).map(Some));
    forms.flat_map(|form| grid.iter().map(move |value| (*value, form.clone()))).collect()
}

/// The columns of an effect at shapes; None where it acts nowhere.
fn make(
    model: &Model<'_>,
    state: &State,
    template: &EffectInstance,
    tried: Vec<(Option<f64>, Option<EffectInstance>)>,
) -> Result<Option<Made>, Error> {
    let Some((value, _)) = tried.first() else { return Ok(None) };
    let shape = searched(template.kind);
    let finite = amplitudes(template.kind).is_empty();
    let at = |effect: &EffectInstance, value: &Option<f64>| {
        let mut effect = effect.clone();
        if let (Some(at), Some(value)) = (shape, value) {
            effect.parameters[at] = *value;
        }
        effect
    };
    let acts = model.acts(&at(template, value));
    if !acts.contains(&true) {
        return Ok(None);
    }
    let mut trials = Vec::new();
    for (value, fuller) in tried {
        let effect = at(fuller.as_ref().unwrap_or(template), &value);
        let with = model.with_acting(state, effect, acts.clone());
        let (columns, _) = model.columns_of_last(state, &with)?;
        let columns = columns.iter().map(|column| Stacked::of(&model.observed, column)).collect();
        trials.push((value, fuller, columns));
    }
    Ok(Some((finite, trials)))
}
