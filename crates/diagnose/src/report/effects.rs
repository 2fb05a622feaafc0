//! The effects that explain, with their parameters and the evidence.

use common::{ExplainedEffect, ListedEffect, Quantity, Rival};
use estimate::screen::Screen;
use indexmap::IndexMap;
use physics::{EffectInstance, Role};
use std::ops::Range;

use super::residuals::floor;
use crate::covariates::on_coil;
use crate::dependence;
use crate::fit::Fitter;
use crate::model::{Column, Model};
use crate::proposal::Addition;
use crate::{Error, Found, Outcome};

/// Where something that was found stands in the final state: the numbers of its effects, and of its columns.
pub(super) fn places_of(outcome: &Outcome, number: usize) -> (Range<usize>, Range<usize>) {
    let count = |found: &[Found], is_effect: bool| {
        let all = found.iter().flat_map(|found| &found.additions);
        all.filter(|one| matches!(one, Addition::Effect(_)) == is_effect).count()
    };
    let (before, own) = (&outcome.found[..number], &outcome.found[number..=number]);
    let first = [outcome.base.state.effects.len() + count(before, true), count(before, false)];
    (first[0]..first[0] + count(own, true), first[1]..first[1] + count(own, false))
}

/// Parameters of an effect of the final state with their uncertainty.
pub fn effect_quantities(model: &Model<'_>, outcome: &Outcome, effect: usize) -> IndexMap<String, Quantity> {
    let state = &outcome.fit.state;
    let free = model.free(state);
    let scale = outcome.last.rest.scale();
    let instance = &state.effects[effect];
    let parameters = instance.kind.parameters().iter().zip(&instance.parameters).enumerate();
    parameters
        .map(|(number, (info, value))| {
            let at = free.iter().position(|(e, p)| (*e, *p) == (effect, number));
            let variance = at.map_or(0.0, |at| {
                let at = model.unknowns.len() + at;
                outcome.fit.covariance[(at, at)] * scale
            });
            let factor = if info.role == Role::Shape { *value } else { 1.0 };
            let std = Some(variance.sqrt() * factor).filter(|std| std.is_finite());
            (info.name.to_string(), std.map_or(Quantity::Bare(*value), |std| Quantity::new(*value, std)))
        })
        .collect()
}

/// Share of the energy of the unknowns from `from` on that the base model leaves.
fn visible(fitter: &Fitter<'_, '_>, outcome: &Outcome, of: &[usize]) -> Result<f64, Error> {
    let base: Vec<usize> = (0..fitter.model.unknowns.len()).collect();
    let jacobian = &outcome.fit.jacobian;
    let screen = Screen::of(&fitter.products(jacobian, &[], &outcome.fit.white)).given(&base)?;
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
            let (effects, columns) = places_of(outcome, number);
            let own = (0..free.len()).filter(|k| effects.contains(&free[*k].0)).map(|k| base + k);
            let own: Vec<usize> = own.chain(columns.clone().map(|k| base + free.len() + k)).collect();
            effect.visible_fraction = visible(fitter, outcome, &own)?;
            for at in effects {
                let instance = &outcome.fit.state.effects[at];
                describe(&mut effect, instance);
                effect.list.push(ListedEffect {
                    recording: instance.recording.clone(),
                    parameters: effect_quantities(model, outcome, at),
                });
            }
            for place in columns {
                let at = base + free.len() + place;
                let std = (outcome.fit.covariance[(at, at)] * outcome.last.rest.scale()).sqrt();
                let column = &outcome.fit.state.columns[place];
                let part = describe_column(&mut effect, column, std);
                effect.list.push(part);
            }
            if effect.list.len() == 1 {
                let one = effect.list.remove(0);
                (effect.recording, effect.parameters) = (one.recording, one.parameters);
            }
            Ok(effect)
        })
        .collect()
}

/// Says what an effect is.
fn describe(effect: &mut ExplainedEffect, instance: &EffectInstance) {
    let about = instance.kind.about();
    let coil = on_coil(instance);
    effect.effect = about.name.into();
    effect.sensor = instance.axis.filter(|_| !coil);
    effect.coil = instance.axis.filter(|_| coil);
    effect.column = instance.column.clone();
    effect.title = about.title.into();
    effect.physics = about.physics.into();
    effect.equation = about.equation.into();
    effect.source = about.source.into();
}

/// Says what a column is: the parameters of a dependence, or of a reading off by itself.
fn describe_column(effect: &mut ExplainedEffect, column: &Column, std: f64) -> ListedEffect {
    let mut parameters = IndexMap::new();
    let size = Quantity::new(column.coefficient, std);
    let Some(follows) = &column.follows else {
        effect.effect = "spike".into();
        effect.equation = "dB = h in one reading".into();
        parameters.insert("height_nt".into(), size);
        return ListedEffect { parameters, ..ListedEffect::default() };
    };
    effect.effect = "dependence".into();
    effect.equation = "dB = c times the column, lagged".into();
    (effect.column, effect.sensor) = (Some(follows.column.clone()), Some(follows.axis));
    parameters.insert(dependence::coefficient(&follows.column), size);
    if follows.lag_s > 0.0 {
        let lag = follows.lag_std_s.map(|std| Quantity::new(follows.lag_s, std));
        parameters.insert("lag_s".into(), lag.unwrap_or(Quantity::Bare(follows.lag_s)));
    }
    ListedEffect { parameters, ..ListedEffect::default() }
}

/// A change of a sum of squares as a change of rms, nT.
fn in_nt(gain: f64, count: f64, floor: f64) -> f64 {
    gain.signum() * (gain.abs() / count).sqrt() * floor
}
