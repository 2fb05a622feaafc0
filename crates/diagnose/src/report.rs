//! What was found, as the document's `diagnosis`.

mod detectable;
mod effects;
mod energy;
mod places;
mod residuals;
mod series;
mod unnamed;

use common::number::{bare, p_value, probability, significant};
use common::{Diagnosis, ExplainedEffect, Remaining, Residual, Share, Verdict};
use std::collections::BTreeSet;

use crate::covariates;
use crate::model::named;
use crate::next::Site;
use crate::search::Searcher;
use crate::verdict::NamedEffect;
use crate::{Error, Outcome, experiment, moved, plain};

pub use detectable::of_all as detectable_of_all;
pub use effects::{described, quantities};
pub use residuals::fit;
pub use series::Drawn;

pub fn report(searcher: &mut Searcher<'_, '_>, outcome: &Outcome, fit: Residual) -> Result<Diagnosis, Error> {
    let (model, level) = (searcher.model, searcher.level);
    let rest = outcome.now.look.rest;
    let omnibus = rest.omnibus();
    let left = outcome.verdict != Verdict::Agrees && !outcome.now.look.clean(level);
    let equal: Vec<&NamedEffect> = outcome.found.iter().filter(|found| !found.equal.is_empty()).collect();
    let verdict = outcome.verdict;
    let mut effects = effects::explained(model, outcome)?;
    let labels: Vec<String> = effects.iter().map(ExplainedEffect::label).collect();
    effects.sort_by(|a, b| b.held_out_gain_nt.total_cmp(&a.held_out_gain_nt));
    let structure = places::structure(outcome, level);
    let mut places: Vec<Share> =
        outcome.found.iter().enumerate().map(|(k, _)| places::share(model, outcome, k)).collect();
    if left {
        places.extend(places::nameless_share(outcome, level));
    }
    let recordings: BTreeSet<String> =
        places.iter().flat_map(|share| share.recordings.iter().cloned()).collect();
    let experiments = match verdict {
        Verdict::Ambiguous => experiment::experiments(model, outcome)?,
        _ => Vec::new(),
    };
    let site = Site::of(&model.observed);
    let next_experiment = match verdict {
        Verdict::Ambiguous => {
            let best = experiments.iter().filter(|experiment| experiment.plan.is_some());
            let words: Vec<String> = best.map(|experiment| experiment.what.clone()).collect();
            let local = equal.iter().all(|found| found.local);
            Some(if words.is_empty() { site.ambiguous(local) } else { words.join("; ") })
        }
        Verdict::Unexplained | Verdict::PartlyExplained => {
            outcome.now.look.structures.first().map(|first| site.unexplained(&first.covariate))
        }
        _ => None,
    };
    let first = outcome.base.look.rest.omnibus();
    let in_words = |p: Option<f64>| p.map_or("not declared".to_string(), p_value);
    let mut reasons = vec![
        format!(
            "sum of squares per degree of freedom {} after refitting the calibration ({}), {} with the effects found ({})",
            significant(outcome.base.look.rest.sum_of_squares / outcome.base.look.rest.freedom, 4),
            in_words(first),
            significant(rest.sum_of_squares / rest.freedom, 4),
            in_words(omnibus)
        ),
        format!(
            "probability by chance of the most significant structure: {} before, {} after; level {}",
            probability(outcome.base.look.least_p),
            probability(outcome.now.look.least_p),
            bare(level)
        ),
    ];
    if verdict == Verdict::Agrees && rest.is_larger(level) {
        let ratio = (rest.sum_of_squares / rest.freedom).sqrt();
        reasons.push(format!(
            "the residuals show no structure, but scatter {} times as much as the declared noise: correct the declaration",
            significant(ratio, 3)
        ));
    }
    if left {
        reasons.extend(outcome.refused.iter().map(|(name, why)| format!("rejected {name}: {why}")));
    }
    for (number, effect) in outcome.base.fit.state.effects.iter().enumerate() {
        if !outcome.base.fit.state.acts[number].contains(&true) {
            let name = named(effect);
            reasons.push(format!(
                "note: {name} of model.effects acts in no recording: what it needs was not recorded"
            ));
        }
    }
    reasons.extend(model.observed.notes.iter().map(|note| format!("note: {note}")));
    reasons.extend(outcome.notes.iter().map(|note| format!("note: {note}")));
    reasons.extend(plain::reasons(&fit));
    let guilty = places::guilty(model, &places);
    let fields = covariates::fields(model, &outcome.now.fit.state)?;
    let energy =
        if places.is_empty() { Vec::new() } else { energy::energy(model, outcome, &guilty, &fields)? };
    let ambiguity = equal
        .iter()
        .flat_map(|found| std::iter::once(&found.name).chain(found.equal.iter().map(|other| &other.name)))
        .map(|name| vec![name.clone()])
        .collect();
    Ok(Diagnosis {
        verdict,
        reasons,
        recordings: recordings.into_iter().collect(),
        places,
        series: series::series(model, outcome, &labels, &guilty, &fields)?,
        effects,
        families: outcome.families.clone(),
        ambiguity,
        unnamed: unnamed::unnamed(model, outcome, &fields),
        fit: Some(fit),
        energy,
        base_shift: moved::shifts(model, outcome),
        detectable: detectable::detectable(searcher, outcome)?,
        remaining: Some(Remaining {
            white: !left,
            p_value: omnibus,
            p_adjusted: outcome.now.look.least_p,
            structure,
        }),
        next_experiment,
        experiments,
        ..Diagnosis::default()
    })
}
