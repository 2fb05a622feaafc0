//! Structure without a name, adopted as such where it predicts readings that were left out.

use common::{AdoptedStructure, Verdict};
use estimate::gauss_newton::{Directions, Linear};
use faer::Mat;
use nalgebra::Vector3;
use physics::{EffectInstance, Kind};

use crate::Error;
use crate::Outcome;
use crate::covariates::{self, Followed};
use crate::fit::{Fit, Fitter};
use crate::generic::{self, mean_step_s};
use crate::model::Model;
use crate::search::{Searcher, Structure};
use crate::waves::range;
use crate::what::What;

/// Most structures that are adopted, and that are tried.
const MOST: usize = 6;
const TRIED: usize = 12;
/// By what share each must lower the rms of readings that were left out.
const LOWERS: f64 = 0.01;

/// Adds to the final fit of an answer that leaves something what is left in it, one structure after another, each
/// the most significant that lowers the rms of readings that are left out.
pub fn adopt(
    model: &Model<'_>,
    searcher: &mut Searcher<'_>,
    outcome: &mut Outcome,
) -> Result<Vec<AdoptedStructure>, Error> {
    if !matches!(outcome.verdict, Verdict::PartlyExplained | Verdict::Unexplained) {
        return Ok(Vec::new());
    }
    let fields = covariates::fields(model, &outcome.fit.state)?;
    let (mut adopted, mut tried): (Vec<AdoptedStructure>, Vec<EffectInstance>) = (Vec::new(), Vec::new());
    let mut before = left_out(&Fitter { model, noise: &outcome.noise }, &outcome.fit)?;
    while adopted.len() < MOST && tried.len() < TRIED {
        let mut effects =
            outcome.last.structures.iter().filter_map(|structure| form(model, &fields, structure));
        let fresh = |effect: &EffectInstance| {
            !tried
                .iter()
                .any(|other| (&other.column, other.parameters[2]) == (&effect.column, effect.parameters[2]))
        };
        let Some(effect) = effects.find(fresh) else { break };
        tried.push(effect.clone());
        let fitter = Fitter { model, noise: &outcome.noise };
        let fit = fitted(&fitter, &outcome.fit, &effect)?;
        let after = left_out(&fitter, &fit)?;
        if after > (1.0 - LOWERS) * before {
            continue;
        }
        adopted.push(AdoptedStructure {
            column: effect.column.clone().unwrap_or_default(),
            lag_s: Some(effect.parameters[2]).filter(|lag_s| *lag_s > 0.0),
            held_out_before_nt: before,
            held_out_after_nt: after,
        });
        before = after;
        outcome.last = searcher.look(&fitter, &fit)?;
        outcome.fit = fit;
    }
    Ok(adopted)
}

/// A fit with structure added: its coefficients by least squares, all else held. What has no physics says nothing
/// of the calibration.
fn fitted(fitter: &Fitter<'_, '_>, fit: &Fit, effect: &EffectInstance) -> Result<Fit, Error> {
    let mut state = fitter.model.with(&fit.state, effect.clone());
    let from = fit.state.effects.len();
    let free = fitter.model.free(&state);
    let own: Vec<usize> = (0..free.len()).filter(|k| free[*k].0 == from).collect();
    let columns = fitter.at(&state)?.jacobian;
    let column = |k: usize| fitter.model.unknowns.len() + own[k];
    let columns = Mat::from_fn(columns.nrows(), own.len(), |i, k| columns[(i, column(k))]);
    let step = Directions::of_products(columns, &fit.white)?.step(0.0);
    for (k, size) in own.iter().zip(step) {
        state.effects[from].parameters[free[*k].1] = size;
    }
    fitter.at(&state)
}

/// Rms of readings that are left out of a fit, nT.
fn left_out(fitter: &Fitter<'_, '_>, fit: &Fit) -> Result<f64, Error> {
    let known: Vec<f64> = fitter.held_out(fit)?.squares.into_iter().flatten().collect();
    Ok((known.iter().sum::<f64>() / known.len().max(1) as f64 * fitter.noise.variance()).sqrt())
}

/// The effect that follows what a structure follows, coefficients zero.
fn form(model: &Model<'_>, fields: &[Vec<Vector3<f64>>], structure: &Structure) -> Option<EffectInstance> {
    let What::Smooth { covariate, axis } = &structure.what else { return None };
    let Followed { name, column, past } = covariates::followed(covariate, *axis)?;
    let runs = &model.observed.runs;
    let step_s = runs.iter().find_map(|run| run.time_s.map(mean_step_s));
    let lag_s = if past { structure.shape? * step_s? } else { 0.0 };
    let series = |number: usize| match (name, runs[number].time_s) {
        ("time_s", Some(time)) => {
            Some(time.iter().map(|t| t + runs[number].setting.context.clock_s).collect())
        }
        _ => covariates::values(model, fields, number, Some(*axis), name),
    };
    let mut series: Vec<Option<Vec<f64>>> = (0..runs.len()).map(series).collect();
    if past {
        let before = generic::past(model, &series, |_| lag_s);
        for (own, before) in series.iter_mut().zip(before) {
            let off = own.iter().flatten().zip(before.iter().flatten()).map(|(own, before)| own - before);
            *own = Some(off.collect());
        }
    }
    let [from, to] = range(series.iter().flatten().flatten())?;
    let mut effect =
        EffectInstance::new(Kind::Empirical, None, vec![0.0; Kind::Empirical.parameters().len()]);
    effect.column = Some(column);
    effect.parameters[..3].copy_from_slice(&[from, to, lag_s]);
    Some(effect)
}
