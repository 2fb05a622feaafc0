//! The effects of the document's model: what they add to the readings is taken off before the directions are sought, and what is
//! uncertain about them is in the uncertainty of the directions.

use common::number::significant;
use common::uncertainty::{self, By};
use common::{AdoptedEffect, Axis, Document, Quantity, procedure};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};
use physics::{EffectInstance, LeftOut, References, Role, Setting};

use crate::joint::{self, Split};
use crate::observe::observe_without;
use crate::{Error, Observations, Options, Solution, observe, solve};

/// Rounds in which directions and effects settle: what effects add is some 10⁻⁴ of the field, and so is what the second round
/// leaves of what the first one had wrong.
const ROUNDS: usize = 2;

/// What effects add to the readings of the recordings, nT along each sensor; a recording without any has no rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Added {
    recordings: Vec<Vec<Vector3<f64>>>,
    left_out: Vec<LeftOut>,
}

impl Added {
    /// The field along a sensor that effects add in each row, nT; None where none acts.
    pub fn along(&self, recording: usize, sensor: Axis) -> Option<Vec<f64>> {
        let rows = self.recordings.get(recording).filter(|rows| !rows.is_empty())?;
        Some(rows.iter().map(|field| field[sensor.index()]).collect())
    }

    fn largest(&self) -> f64 {
        let fields = self.recordings.iter().flatten().map(|field| field.amax());
        fields.filter(|field| field.is_finite()).fold(0.0, f64::max)
    }
}

/// Readings without what the model's effects add to them, and the directions that follow from them.
pub(crate) struct Solved {
    pub observations: Observations,
    pub solution: Solution,
    pub split: Split,
}

/// Takes the effects off and solves.
pub(crate) fn solve_without(document: &Document, options: &Options) -> Result<Solved, Error> {
    let mut observations = observe(document, options)?;
    let effects = effects(document)?;
    if effects.is_empty() {
        let mut solution = solve(document, &observations, options)?;
        let split = joint::restate(document, &observations, &mut solution, Vec::new())?;
        return Ok(Solved { observations, solution, split });
    }
    let mut directions = None;
    let mut rounds = 0;
    loop {
        let added = added(document, &effects, directions)?;
        observations = observe_without(document, options, &added)?;
        let mut solution = solve(document, &observations, options)?;
        rounds += 1;
        if rounds == ROUNDS {
            let by = by_effects(document, options, &effects, &observations, &solution)?;
            let split = joint::restate(document, &observations, &mut solution, by)?;
            observations.findings.extend(words(&effects, &added));
            return Ok(Solved { observations, solution, split });
        }
        directions = Some((solution.fit.state.mu, solution.fit.state.eta));
    }
}

/// The model's effects that act in a recording for axescal.
fn effects(document: &Document) -> Result<Vec<EffectInstance>, Error> {
    let all = physics::adopt(document).map_err(|error| error.at("model"))?;
    let acts = |effect: &EffectInstance| {
        let mut mine = document.recordings.iter().filter(|one| one.procedure == procedure::AXES_ORIENTATION);
        mine.any(|recording| effect.acts(recording))
    };
    Ok(all.into_iter().filter(acts).collect())
}

/// The reading with the effects less the reading without, as field, for sensors and coils in these directions; None: as the document
/// states them.
fn added(
    document: &Document,
    effects: &[EffectInstance],
    directions: Option<(Matrix3<f64>, Matrix3<f64>)>,
) -> Result<Added, Error> {
    let references = References::of(document);
    let mut all = Added { recordings: vec![Vec::new(); document.recordings.len()], left_out: Vec::new() };
    for (index, recording) in document.recordings.iter().enumerate() {
        let acting: Vec<EffectInstance> =
            effects.iter().filter(|effect| effect.acts(recording)).cloned().collect();
        if recording.procedure != procedure::AXES_ORIENTATION || acting.is_empty() {
            continue;
        }
        let at = |error: physics::Error| error.at(&format!("recordings[{index}]"));
        let mut setting = Setting::of(document, recording, references).map_err(at)?;
        if let Some((mu, eta)) = directions {
            (setting.basic.mu, setting.basic.eta) = (mu, eta);
        }
        let Setting { basic, context } = setting;
        let (with, left_out) = physics::predict_acting(&basic, &acting, &context).map_err(at)?;
        let without = physics::predict(&basic, &[], &context).map_err(at)?;
        let scale = Vector3::from(basic.sensors.map(|sensor| sensor.sensitivity));
        all.recordings[index] = with
            .readings
            .iter()
            .zip(&without.readings)
            .map(|(with, without)| (with - without).component_mul(&scale))
            .collect();
        all.left_out.extend(left_out);
    }
    Ok(all)
}

/// How the unknowns err with the parameters of the effects: C Jᵀ Δ for each unit, Δ the change of the readings.
fn by_effects(
    document: &Document,
    options: &Options,
    effects: &[EffectInstance],
    observations: &Observations,
    solution: &Solution,
) -> Result<By, Error> {
    let adopted: Vec<&AdoptedEffect> = document.model.iter().flat_map(|model| &model.effects).collect();
    let directions = Some((solution.fit.state.mu, solution.fit.state.eta));
    let unknowns = solution.meaning.len();
    let mut by = Vec::new();
    for (number, effect) in effects.iter().enumerate() {
        let Some(stated) = adopted.iter().find(|one| stands_for(one, effect)) else { continue };
        for (place, info) in effect.kind.parameters().iter().enumerate() {
            let std = stated.parameters.get(info.name).and_then(Quantity::std).unwrap_or(0.0);
            if std <= 0.0 || info.role == Role::Epoch {
                continue;
            }
            let mut moved = effects.to_vec();
            moved[number].parameters[place] += std;
            let moved = observe_without(document, options, &added(document, &moved, directions)?)?;
            let change = |row: usize| {
                let (before, after) = (&observations.readings[row], &moved.readings[row]);
                (after.value_nt - before.value_nt) / (before.std_nt * solution.noise_factor * std)
            };
            let readings = observations.readings.len();
            let gradient = Mat::from_fn(unknowns, 1, |k, _| {
                (0..readings).map(|row| solution.fit.jacobian[(row, k)] * change(row)).sum::<f64>()
            });
            let shift = &solution.covariance * &gradient;
            let shift = (0..unknowns).map(|k| shift[(k, 0)]).collect();
            by.push((uncertainty::effect(stated, info.name), shift));
        }
    }
    Ok(by)
}

/// Whether an entry of the model is this effect.
fn stands_for(adopted: &AdoptedEffect, effect: &EffectInstance) -> bool {
    adopted.effect == effect.kind.name()
        && adopted.sensor.or(adopted.coil) == effect.axis
        && adopted.column == effect.column
        && adopted.recording == effect.recording
}

/// What is to be said of it.
fn words(effects: &[EffectInstance], added: &Added) -> Vec<String> {
    let mut names: Vec<&str> = Vec::new();
    for name in effects.iter().map(|effect| effect.kind.name()) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let largest = added.largest();
    let mut words = vec![format!(
        "taken off the readings, at most {} nT: {} of the model",
        significant(largest, 3),
        names.join(", ")
    )];
    let mut told: Vec<(&str, &str)> = Vec::new();
    for LeftOut { recording, who, what } in &added.left_out {
        if !told.contains(&(who, what)) {
            told.push((who, what));
            words.push(format!("{who} is left out in \"{recording}\", for want of {what}"));
        }
    }
    words
}
