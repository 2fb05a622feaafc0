//! The effects that explain, with their parameters and the evidence.

use common::{Axis, ExplainedEffect, ListedEffect, Quantity, Rival, Verdict};
use indexmap::IndexMap;
use physics::{EffectInstance, Kind, Role};
use std::ops::Range;

use super::residuals::floor;
use crate::covariates::on_coil;
use crate::fit::Fitter;
use crate::lattice;
use crate::model::Model;
use crate::proposal::Addition;
use crate::sized;
use crate::{Error, NamedEffect, Outcome};

/// A variance that rests on what is assumed of an effect's departures from its equation by more than this
/// share is a lower bound: no recording bounds those.
const BY_FORMS: f64 = 0.5;
/// Standard uncertainties from which a coefficient is beyond chance.
const BEYOND_CHANCE: f64 = 3.0;

/// Where something that was found stands in the final state: the numbers of its effects, and of its single readings.
pub(super) fn places_of(outcome: &Outcome, number: usize) -> (Range<usize>, Range<usize>) {
    let count = |found: &[NamedEffect], is_effect: bool| {
        let all = found.iter().flat_map(|found| &found.additions);
        all.filter(|one| matches!(one, Addition::Effect(_)) == is_effect).count()
    };
    let (before, own) = (&outcome.found[..number], &outcome.found[number..=number]);
    let first = [outcome.base.state.effects.len() + count(before, true), count(before, false)];
    (first[0]..first[0] + count(own, true), first[1]..first[1] + count(own, false))
}

/// Parameters of the effects of the final state with their uncertainty.
pub fn quantities(model: &Model<'_>, outcome: &Outcome) -> Vec<IndexMap<String, Quantity>> {
    (0..outcome.fit.state.effects.len()).map(|effect| effect_quantities(model, outcome, effect)).collect()
}

fn effect_quantities(model: &Model<'_>, outcome: &Outcome, effect: usize) -> IndexMap<String, Quantity> {
    let state = &outcome.fit.state;
    let free = model.free(state);
    let rest = &outcome.last.rest;
    // Something is left that no model has, or another name is as good.
    let open = matches!(outcome.verdict, Verdict::PartlyExplained | Verdict::Ambiguous);
    let instance = &state.effects[effect];
    let parameters = instance.kind.parameters().iter().zip(&instance.parameters).enumerate();
    parameters
        .map(|(number, (info, value))| {
            let at = free.iter().position(|(e, p)| (*e, *p) == (effect, number));
            let fitted = |at: usize| {
                let at = model.unknowns.len() + at;
                let factor = if info.role == Role::Shape { *value } else { 1.0 };
                (outcome.fit.covariance[(at, at)] * rest.scale()).sqrt() * factor
            };
            // The moment of a step or a spike is that of a row, and has no uncertainty that follows from a
            // fit.
            let std = match instance.kind {
                Kind::Quantisation => lattice::width_std(model, state, instance),
                _ => at.map_or(0.0, fitted),
            };
            let quantity = sized::quantity(*value, std, rest.known + rest.freedom, Some(info));
            let of_forms = |at: usize| {
                let at = model.unknowns.len() + at;
                outcome.fit.beyond[(at, at)] > BY_FORMS * outcome.fit.covariance[(at, at)]
            };
            let at_least = open || at.is_some_and(of_forms);
            (info.name.to_string(), if at_least { quantity.at_least() } else { quantity })
        })
        .collect()
}

/// Share of the energy of the unknowns from `from` on that the base model leaves.
fn visible(fitter: &Fitter<'_, '_>, outcome: &Outcome, of: &[usize]) -> Result<f64, Error> {
    let base: Vec<usize> = (0..fitter.model.unknowns.len()).collect();
    let jacobian = &outcome.fit.jacobian;
    let screen = fitter.screen(jacobian, &[], &outcome.fit.white).given(&base)?;
    let (mut left, mut whole) = (0.0, 0.0);
    for column in of {
        let energy: f64 = jacobian.col_as_slice(*column).iter().map(|value| value * value).sum();
        (left, whole) = (left + screen.visible(*column) * energy, whole + energy);
    }
    Ok(if whole > 0.0 { left / whole } else { 0.0 })
}

pub(super) fn explained(
    model: &Model<'_>,
    outcome: &Outcome,
    fitter: &Fitter<'_, '_>,
) -> Result<Vec<ExplainedEffect>, Error> {
    let base = model.unknowns.len();
    let free = model.free(&outcome.fit.state);
    let floor = floor(outcome);
    outcome
        .found
        .iter()
        .enumerate()
        .map(|(number, found)| {
            let rivals = found
                .lost
                .iter()
                .map(|(effect, why_not)| Rival { effect: effect.clone(), why_not: why_not.clone() });
            let count = outcome.fit.residual.len() as f64;
            let gains: Vec<f64> =
                found.held_out.iter().map(|gain| in_nt(*gain, count / 6.0, floor)).collect();
            let mut effect = ExplainedEffect {
                p_adjusted: found.p_adjusted,
                probability: Some(found.probability),
                share: Some(found.share),
                departure: Some(found.departure),
                title: found.name.clone(),
                held_out_gain_nt: in_nt(found.held_out.iter().sum(), count, floor),
                held_out_by_block_nt: gains,
                rivals: rivals.collect(),
                ..ExplainedEffect::default()
            };
            let (effects, singles) = places_of(outcome, number);
            let own = (0..free.len()).filter(|k| effects.contains(&free[*k].0)).map(|k| base + k);
            let own: Vec<usize> = own.chain(singles.clone().map(|k| base + free.len() + k)).collect();
            effect.visible_fraction = visible(fitter, outcome, &own)?;
            let instances = &outcome.fit.state.effects[effects.clone()];
            let several_sensors = instances.iter().any(|instance| instance.axis != instances[0].axis);
            for at in effects {
                let instance = &outcome.fit.state.effects[at];
                describe(&mut effect, instance, &outcome.parameters[at]);
                effect.list.push(ListedEffect {
                    recording: instance.recording.clone(),
                    parameters: outcome.parameters[at].clone(),
                });
            }
            for place in singles {
                let at = base + free.len() + place;
                let std = (outcome.fit.covariance[(at, at)] * outcome.last.rest.scale()).sqrt();
                effect.effect = Kind::Spike.name().into();
                effect.equation = "dB = h in one reading".into();
                let height = Quantity::new(outcome.fit.state.singles[place].height_nt, std);
                let parameters = [("height_nt".to_string(), height)].into_iter().collect();
                effect.list.push(ListedEffect { parameters, ..ListedEffect::default() });
            }
            if several_sensors {
                together(&mut effect, instances);
            }
            if effect.list.len() == 1 {
                let one = effect.list.remove(0);
                (effect.recording, effect.parameters) = (one.recording, one.parameters);
            }
            Ok(effect)
        })
        .collect()
}

/// What happened in several sensors at one moment as one, with an amplitude for each.
fn together(effect: &mut ExplainedEffect, instances: &[EffectInstance]) {
    let mut parameters = IndexMap::new();
    let mut parts: Vec<_> = effect.list.iter().zip(instances).collect();
    parts.sort_by_key(|(_, instance)| instance.axis.map(Axis::index));
    for (part, instance) in parts {
        let infos = instance.kind.parameters().iter().zip(&part.parameters);
        for (info, (name, value)) in infos {
            let name = match instance.axis.filter(|_| info.role == Role::Amplitude) {
                Some(axis) => format!("{axis}_{name}"),
                None => name.clone(),
            };
            parameters.insert(name, value.clone());
        }
    }
    // What they share stands behind.
    parameters.sort_by_key(|name, _| !Axis::ALL.iter().any(|axis| name.starts_with(&format!("{axis}_"))));
    let recording = instances[0].recording.clone();
    effect.sensor = None;
    effect.list = vec![ListedEffect { recording, parameters }];
}

/// Says what an effect is.
fn describe(
    effect: &mut ExplainedEffect,
    instance: &EffectInstance,
    parameters: &IndexMap<String, Quantity>,
) {
    let about = instance.kind.about();
    let coil = on_coil(instance);
    effect.effect = about.name.into();
    effect.sensor = match (instance.axis, &followers(parameters)[..]) {
        (None, [only]) => Some(*only),
        (axis, _) => axis.filter(|_| !coil),
    };
    effect.coil = instance.axis.filter(|_| coil);
    effect.column = instance.column.clone();
    effect.title = about.title.into();
    effect.physics = about.physics.into();
    effect.equation = about.equation.into();
    effect.source = about.source.into();
}

/// The sensors that follow a column beyond chance.
pub(super) fn followers(parameters: &IndexMap<String, Quantity>) -> Vec<Axis> {
    let follows = |axis: &Axis| {
        let coefficient = parameters.get(&format!("{axis}_nt_per_unit"));
        coefficient.is_some_and(|c| c.std().is_some_and(|std| c.value().abs() > BEYOND_CHANCE * std))
    };
    Axis::ALL.into_iter().filter(follows).collect()
}

/// A change of a sum of squares as a change of rms, nT.
fn in_nt(gain: f64, count: f64, floor: f64) -> f64 {
    gain.signum() * (gain.abs() / count).sqrt() * floor
}
