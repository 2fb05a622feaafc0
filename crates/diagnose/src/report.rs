//! What was found, as the document's `diagnosis`.

mod detectable;
mod effects;
mod energy;
mod guilty;
mod places;
mod residuals;
mod rivals;
mod series;
mod unnamed;

use common::number::{bare, p_value, probability, significant};
use common::{Diagnosis, Document, ExplainedEffect, Remaining, Residual, Share, Verdict};

use crate::covariates;
use crate::fit::Fitter;
use crate::model::Model;
use crate::next::Site;
use crate::search::Searcher;
use crate::what::{What, named};
use crate::{Error, NamedEffect, Options, Outcome, experiment, moved, plain};

pub use detectable::of_all as detectable_of_all;
pub use effects::quantities;
pub use residuals::fit;

/// The entry of a document.
pub fn report(
    document: &Document,
    model: &Model<'_>,
    searcher: &mut Searcher,
    outcome: &Outcome,
    fit: Residual,
    options: &Options,
) -> Result<Diagnosis, Error> {
    let rest = outcome.last.rest;
    let omnibus = rest.omnibus();
    let left = outcome.verdict != Verdict::Agrees && !outcome.last.clean(options.level);
    let equal: Vec<&NamedEffect> = outcome.found.iter().filter(|found| !found.equal.is_empty()).collect();
    let verdict = outcome.verdict;
    let fitter = Fitter { model, noise: &outcome.noise };
    let mut effects = effects::explained(model, outcome, &fitter)?;
    let labels: Vec<String> = effects.iter().map(ExplainedEffect::label).collect();
    effects.sort_by(|a, b| b.held_out_gain_nt.total_cmp(&a.held_out_gain_nt));
    let structure = places::structure(outcome, options);
    let mut places: Vec<Share> =
        outcome.found.iter().enumerate().map(|(k, _)| places::share(model, outcome, k)).collect();
    if left {
        places.extend(places::nameless_share(outcome, options));
    }
    let mut recordings: Vec<String> =
        places.iter().flat_map(|share| share.recordings.iter().cloned()).collect();
    recordings.sort();
    recordings.dedup();
    let experiments = match verdict {
        Verdict::Ambiguous => experiment::experiments(document, model, outcome)?,
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
            outcome.last.structures.first().map(|s| match &s.what {
                What::Smooth { covariate, .. } => site.unexplained(covariate),
                What::Physics(_) => String::new(),
            })
        }
        _ => None,
    };
    let first = outcome.first.rest.omnibus();
    let in_words = |p: Option<f64>| p.map_or("not declared".to_string(), p_value);
    let mut reasons = vec![
        format!(
            "sum of squares per degree of freedom {} after refitting the calibration ({}), {} with the effects found ({})",
            significant(outcome.first.rest.sum_of_squares / outcome.first.rest.freedom, 4),
            in_words(first),
            significant(rest.sum_of_squares / rest.freedom, 4),
            in_words(omnibus)
        ),
        format!(
            "probability by chance of the most significant structure: {} before, {} after; level {}",
            probability(outcome.first.least_p),
            probability(outcome.last.least_p),
            bare(options.level)
        ),
    ];
    if verdict == Verdict::Agrees && rest.is_larger(options.level) {
        let ratio = (rest.sum_of_squares / rest.freedom).sqrt();
        reasons.push(format!(
            "the residuals show no structure, but scatter {} times as much as the declared noise: correct the declaration",
            significant(ratio, 3)
        ));
    }
    if left {
        reasons.extend(outcome.refused.iter().map(|(name, why)| format!("rejected {name}: {why}")));
    }
    for (number, effect) in outcome.base.state.effects.iter().enumerate() {
        if !outcome.base.state.acts[number].contains(&true) {
            let name = named(effect);
            reasons.push(format!(
                "note: {name} of model.effects acts in no recording: what it needs was not recorded"
            ));
        }
    }
    reasons.extend(model.observed.notes.iter().map(|note| format!("note: {note}")));
    reasons.extend(outcome.notes.iter().map(|note| format!("note: {note}")));
    reasons.extend(plain::reasons(&fit));
    let guilty = guilty::guilty(model, &places);
    let fields = covariates::fields(model, &outcome.fit.state)?;
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
        recordings,
        places,
        series: series::series(model, outcome, &labels, &guilty, &fields)?,
        effects,
        families: outcome.families.clone(),
        ambiguity,
        unnamed: unnamed::unnamed(model, outcome, &fields),
        fit: Some(fit),
        energy,
        base_shift: moved::shifts(model, outcome),
        detectable: detectable::detectable(searcher, outcome, &fitter, options)?,
        remaining: Some(Remaining {
            white: !left,
            p_value: omnibus,
            p_adjusted: outcome.last.least_p,
            structure,
        }),
        next_experiment,
        experiments,
        ..Diagnosis::default()
    })
}
