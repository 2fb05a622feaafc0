//! The effects that explain, with their parameters and the evidence.

use common::{ExplainedEffect, Quantity, Rival};
use estimate::screen::Screen;
use indexmap::IndexMap;
use physics::{EffectInstance, Role};

use super::residuals::floor;
use crate::covariates::on_coil;
use crate::dependence;
use crate::fit::Fitter;
use crate::model::Model;
use crate::proposal::Addition;
use crate::{Error, Found, Outcome};

/// The number of an effect of the state that a found thing is, or of a column.
pub(super) fn place_of(outcome: &Outcome, number: usize) -> usize {
    let same = |found: &&Found| {
        matches!(found.addition, Addition::Effect(_))
            == matches!(outcome.found[number].addition, Addition::Effect(_))
    };
    outcome.found[..number].iter().filter(same).count()
}

/// The effect of a found thing at the final fit.
pub(super) fn effect_of(outcome: &Outcome, number: usize) -> Option<(usize, &EffectInstance)> {
    match outcome.found[number].addition {
        Addition::Effect(_) => {
            let at = outcome.base.state.effects.len() + place_of(outcome, number);
            Some((at, &outcome.fit.state.effects[at]))
        }
        Addition::Column(_) => None,
    }
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
                held_out_gain_nt: in_nt(found.held_out.iter().sum(), count, floor),
                held_out_by_block_nt: gains,
                rivals: rivals.collect(),
                ..ExplainedEffect::default()
            };
            match effect_of(outcome, number) {
                Some((at, instance)) => {
                    let about = instance.kind.about();
                    let coil = on_coil(instance);
                    let own: Vec<usize> =
                        (0..free.len()).filter(|k| free[*k].0 == at).map(|k| base + k).collect();
                    effect.effect = about.name.into();
                    effect.sensor = instance.axis.filter(|_| !coil);
                    effect.coil = instance.axis.filter(|_| coil);
                    effect.column = instance.column.clone();
                    effect.recording = instance.recording.clone();
                    effect.title = about.title.into();
                    effect.physics = about.physics.into();
                    effect.equation = about.equation.into();
                    effect.source = about.source.into();
                    effect.parameters = effect_quantities(model, outcome, at);
                    effect.visible_fraction = visible(fitter, outcome, &own)?;
                }
                None => {
                    let place = place_of(outcome, number);
                    let column = &outcome.fit.state.columns[place];
                    let at = base + free.len() + place;
                    let std = (outcome.fit.covariance[(at, at)] * outcome.last.rest.scale()).sqrt();
                    let single = found.local;
                    effect.effect = if single { "spike" } else { "dependence" }.into();
                    effect.title = column.what.clone();
                    effect.equation =
                        if single { "dB = h in one reading" } else { "dB = c times the column, lagged" }
                            .into();
                    let follows = column.follows.as_ref();
                    let name = follows.map_or("height_nt".into(), |f| dependence::coefficient(&f.column));
                    effect.parameters.insert(name, Quantity::new(column.coefficient, std));
                    if let Some(follows) = follows {
                        (effect.column, effect.sensor) = (Some(follows.column.clone()), Some(follows.axis));
                        if follows.lag_s > 0.0 {
                            let lag = follows.lag_std_s.map(|std| Quantity::new(follows.lag_s, std));
                            effect
                                .parameters
                                .insert("lag_s".into(), lag.unwrap_or(Quantity::Bare(follows.lag_s)));
                        }
                    }
                    effect.visible_fraction = visible(fitter, outcome, &[at])?;
                }
            }
            Ok(effect)
        })
        .collect()
}

/// A change of a sum of squares as a change of rms, nT.
fn in_nt(gain: f64, count: f64, floor: f64) -> f64 {
    gain.signum() * (gain.abs() / count).sqrt() * floor
}
