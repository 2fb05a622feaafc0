//! The effects that explain, with their parameters and the evidence.

use common::{Axis, ExplainedEffect, ListedEffect, Quantity, Verdict};
use indexmap::IndexMap;
use physics::{EffectInstance, Kind, Role};
use std::ops::Range;

use super::residuals::floor;
use crate::codes;
use crate::covariates::on_coil;
use crate::model::Model;
use crate::proposal::Addition;
use crate::sized;
use crate::verdict::NamedEffect;
use crate::{Error, Outcome};

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
    let first = [outcome.base.fit.state.effects.len() + count(before, true), count(before, false)];
    (first[0]..first[0] + count(own, true), first[1]..first[1] + count(own, false))
}

/// Parameters of the effects of the final state with their uncertainty.
pub fn quantities(model: &Model<'_>, outcome: &Outcome) -> Vec<IndexMap<String, Quantity>> {
    let (fit, rest) = (&outcome.now.fit, &outcome.now.look.rest);
    let free = model.free(&fit.state);
    // Something is left that no model has, or another name is as good.
    let open = matches!(outcome.verdict, Verdict::PartlyExplained | Verdict::Ambiguous);
    let quantity = |effect: usize, number: usize| {
        let instance = &fit.state.effects[effect];
        let (info, value) = (&instance.kind.parameters()[number], instance.parameters[number]);
        let at = free.iter().position(|of| *of == (effect, number)).map(|at| model.unknowns.len() + at);
        let factor = if info.role == Role::Shape { value } else { 1.0 };
        // The moment of a step or a spike is that of a row, and has no uncertainty that follows from a fit.
        let std = match instance.kind {
            Kind::Quantisation => codes::width_std(model, &fit.state, instance),
            _ => at.map_or(0.0, |at| (fit.covariance[(at, at)] * rest.scale()).sqrt() * factor),
        };
        let quantity = sized::quantity(value, std, rest.known + rest.freedom, Some(info));
        let of_forms = |at: usize| fit.beyond[(at, at)] > BY_FORMS * fit.covariance[(at, at)];
        let at_least = open || at.is_some_and(of_forms);
        (info.name.to_string(), if at_least { quantity.at_least() } else { quantity })
    };
    let of = |effect: usize| {
        (0..fit.state.effects[effect].parameters.len()).map(|number| quantity(effect, number)).collect()
    };
    (0..fit.state.effects.len()).map(of).collect()
}

/// Share of the energy of the unknowns from `from` on that the base model leaves.
fn visible(model: &Model<'_>, outcome: &Outcome, of: &[usize]) -> Result<f64, Error> {
    let base: Vec<usize> = (0..model.unknowns.len()).collect();
    let jacobian = &outcome.now.fit.jacobian;
    let screen = outcome.now.fitter(model).screen(jacobian, &[], &outcome.now.fit.white).given(&base)?;
    let (mut left, mut whole) = (0.0, 0.0);
    for column in of {
        let energy: f64 = jacobian.col_as_slice(*column).iter().map(|value| value * value).sum();
        (left, whole) = (left + screen.visible(*column) * energy, whole + energy);
    }
    Ok(if whole > 0.0 { left / whole } else { 0.0 })
}

pub(super) fn explained(model: &Model<'_>, outcome: &Outcome) -> Result<Vec<ExplainedEffect>, Error> {
    (0..outcome.found.len()).map(|number| one(model, outcome, number)).collect()
}

fn one(model: &Model<'_>, outcome: &Outcome, number: usize) -> Result<ExplainedEffect, Error> {
    let (found, fit) = (&outcome.found[number], &outcome.now.fit);
    let (base, free, floor) = (model.unknowns.len(), model.free(&fit.state), floor(outcome));
    let (effects, singles) = places_of(outcome, number);
    let instances = &fit.state.effects[effects.clone()];
    let parameters = &outcome.parameters[effects.clone()];
    let own = (0..free.len()).filter(|k| effects.contains(&free[*k].0)).map(|k| base + k);
    let own: Vec<usize> = own.chain(singles.clone().map(|k| base + free.len() + k)).collect();
    let count = fit.residual.len() as f64;
    let what = match instances.iter().zip(parameters).next_back() {
        Some((instance, parameters)) => acting(instance, parameters),
        None => ExplainedEffect {
            effect: Kind::Spike.name().into(),
            equation: "dB = h in one reading".into(),
            title: found.name.clone(),
            ..ExplainedEffect::default()
        },
    };
    let listed = instances.iter().zip(parameters).map(|(instance, parameters)| ListedEffect {
        recording: instance.recording.clone(),
        parameters: parameters.clone(),
    });
    let readings = singles.map(|place| {
        let at = base + free.len() + place;
        let std = (fit.covariance[(at, at)] * outcome.now.look.rest.scale()).sqrt();
        let height = Quantity::new(fit.state.singles[place].height_nt, std);
        let parameters = [("height_nt".to_string(), height)].into_iter().collect();
        ListedEffect { parameters, ..ListedEffect::default() }
    });
    let mut effect = ExplainedEffect {
        p_adjusted: found.p,
        probability: Some(found.probability),
        share: Some(found.share),
        departure: Some(found.departure),
        held_out_gain_nt: in_nt(found.held_out.iter().sum(), count, floor),
        held_out_by_block_nt: found.held_out.iter().map(|gain| in_nt(*gain, count / 6.0, floor)).collect(),
        rivals: found.lost.clone(),
        visible_fraction: visible(model, outcome, &own)?,
        list: listed.chain(readings).collect(),
        ..what
    };
    if instances.iter().any(|instance| instance.axis != instances[0].axis) {
        together(&mut effect, instances);
    }
    if effect.list.len() == 1 {
        let one = effect.list.remove(0);
        (effect.recording, effect.parameters) = (one.recording, one.parameters);
    }
    Ok(effect)
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

/// An effect of the catalogue in its words.
pub fn described(kind: Kind) -> ExplainedEffect {
    let about = kind.about();
    ExplainedEffect {
        effect: about.name.into(),
        title: about.title.into(),
        physics: about.physics.into(),
        equation: about.equation.into(),
        source: about.source.into(),
        ..ExplainedEffect::default()
    }
}

/// The same with what it acts on.
fn acting(instance: &EffectInstance, parameters: &IndexMap<String, Quantity>) -> ExplainedEffect {
    let coil = on_coil(instance);
    ExplainedEffect {
        sensor: match (instance.axis, &followers(parameters)[..]) {
            (None, [only]) => Some(*only),
            (axis, _) => axis.filter(|_| !coil),
        },
        coil: instance.axis.filter(|_| coil),
        column: instance.column.clone(),
        ..described(instance.kind)
    }
}

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
