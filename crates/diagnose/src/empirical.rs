//! Structure without a name, adopted as such where it predicts readings that were left out.

use common::{AdoptedStructure, Axis, Verdict};
use estimate::gauss_newton::{Directions, Linear};
use faer::Mat;
use nalgebra::Vector3;
use physics::{EffectInstance, Kind};

use crate::Error;
use crate::Outcome;
use crate::algebra::square;
use crate::covariates::{self, TIMES};
use crate::fit::{Fit, Fitter, settled_white};
use crate::generic;
use crate::model::Model;
use crate::search::{Searcher, Structure};
use crate::waves::{mean_step_s, range};

/// Most structures that are adopted, and that are tried.
const MOST: usize = 6;
const TRIED: usize = 12;
/// By what share each must lower the rms of readings that were left out.
const LOWERS: f64 = 0.01;

/// Adds to the final fit of an answer that leaves something what is left in it, one structure after another, each
/// the most significant that lowers the rms of readings that are left out, and that of all. Noise that nobody declared
/// is white here: with memory it takes all that is slow for itself.
pub fn adopt(searcher: &mut Searcher<'_, '_>, outcome: &mut Outcome) -> Result<Vec<AdoptedStructure>, Error> {
    let model = searcher.model;
    if !matches!(outcome.verdict, Verdict::PartlyExplained | Verdict::Unexplained) {
        return Ok(Vec::new());
    }
    let slow = (0..model.observed.channels.len()).any(|channel| outcome.now.noise.remembers(channel));
    let mut best = outcome.now.clone();
    if best.noise.known == 0.0 && slow {
        let (fit, white) = settled_white(model, &best.fit.state)?;
        best = searcher.ground(fit, white)?;
    }
    let noise = best.noise.clone();
    let fitter = Fitter { model, noise: &noise };
    let fields = covariates::fields(model, &outcome.now.fit.state)?;
    let (mut adopted, mut tried) = (Vec::new(), Vec::new());
    let mut before = left_out(&fitter, &best.fit)?;
    while adopted.len() < MOST && tried.len() < TRIED {
        let mut groups = best.look.structures.iter().filter_map(|structure| form(model, &fields, structure));
        let Some(group) = groups.find(|group| !tried.contains(&what(&group[0]))) else { break };
        tried.push(what(&group[0]));
        let mut fit = best.fit.clone();
        for effect in &group {
            fit = fitted(&fitter, &fit, effect)?;
        }
        let after = left_out(&fitter, &fit)?;
        if after > (1.0 - LOWERS) * before || square(&fit.residual) > square(&best.fit.residual) {
            continue;
        }
        adopted.push(AdoptedStructure {
            column: group[0].column.clone().unwrap_or_default(),
            lag_s: Some(group[0].parameters[2]).filter(|lag_s| *lag_s > 0.0),
            held_out_before_nt: before,
            held_out_after_nt: after,
        });
        before = after;
        best = searcher.ground(fit, noise.clone())?;
    }
    if !adopted.is_empty() {
        outcome.now = best;
    }
    Ok(adopted)
}

/// What an effect follows, and how late.
fn what(effect: &EffectInstance) -> (Option<String>, f64) {
    (effect.column.clone(), effect.parameters[2])
}

/// A fit with structure added, all else held: what has no physics says nothing of the calibration.
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

/// The effects that follow what a structure follows, coefficients zero: of time one in each recording, for what acts
/// unseen begins anew; beside a product each of the two.
fn form(
    model: &Model<'_>,
    fields: &[Vec<Vector3<f64>>],
    structure: &Structure,
) -> Option<Vec<EffectInstance>> {
    let Structure { covariate, axis, .. } = structure;
    let names = covariate.split(TIMES).filter(|name| *name != covariate);
    let all = std::iter::once(covariate.as_str()).chain(names);
    let all = all.map(|name| one(model, fields, (name, *axis), structure.shape));
    Some(all.collect::<Option<Vec<_>>>()?.concat()).filter(|group| !group.is_empty())
}

/// The effects that follow one covariate of a sensor.
fn one(
    model: &Model<'_>,
    fields: &[Vec<Vector3<f64>>],
    (covariate, axis): (&str, Axis),
    shape: Option<f64>,
) -> Option<Vec<EffectInstance>> {
    let (name, column, past) = covariates::followed(covariate, axis)?;
    let runs = &model.observed.runs;
    let step_s = runs.iter().find_map(|run| run.time_s.map(mean_step_s));
    let lag_s = if past { shape? * step_s? } else { 0.0 };
    let series = |number: usize| covariates::values(model, fields, number, Some(axis), name);
    let mut series: Vec<Option<Vec<f64>>> = (0..runs.len()).map(series).collect();
    if past {
        let before = generic::past(model, &series, |_| lag_s);
        for (own, before) in series.iter_mut().zip(before) {
            let off = own.iter().flatten().zip(before.iter().flatten()).map(|(own, before)| own - before);
            *own = Some(off.collect());
        }
    }
    let of = |series: &[Option<Vec<f64>>], recording: Option<String>| {
        let [from, to] = range(series.iter().flatten().flatten())?;
        let mut effect =
            EffectInstance::new(Kind::Empirical, None, vec![0.0; Kind::Empirical.parameters().len()]);
        (effect.column, effect.recording) = (Some(column.clone()), recording);
        effect.parameters[..3].copy_from_slice(&[from, to, lag_s]);
        Some(effect)
    };
    if name != "time_s" {
        return Some(vec![of(&series, None)?]);
    }
    let each = series.chunks(1).zip(runs).filter_map(|(own, run)| of(own, Some(run.recording.id.clone())));
    Some(each.collect())
}
