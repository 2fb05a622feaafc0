//! What physics did the model leave out? Predicts every recording from `calibration` and `model` and names what explains the
//! difference.
//!
//! Residuals are whitened by the noise as declared. Of every candidate and of the residual the base model's columns are projected out,
//! for the calibration has swallowed a part of every effect. A claim counts all that was searched, shapes and moments
//! included; it must predict readings that were left out, with plausible sizes; and it is a name only where no rival fits as
//! well. What is accepted is fitted together with the calibration and goes to `model.effects`.

mod adopt;
mod against;
mod candidates;
mod codes;
mod covariates;
mod dependence;
mod error;
mod events;
mod fit;
mod generic;
mod held_out;
mod lattice;
mod level;
mod lines;
mod magnitude;
mod matched;
mod model;
mod next;
mod observed;
mod report;
mod rivals;
mod search;
mod smooth;
mod trust;
mod whitening;
mod words;

pub use error::Error;
pub use words::summary;

use common::{Document, Verdict};
use std::collections::BTreeSet;

use crate::candidates::Pool;
use crate::fit::{Fit, Fitter, settled};
use crate::model::Model;
use crate::observed::Observed;
use crate::rivals::{Rivals, best, rivals};
use crate::search::{Addition, Look, Refined, Searcher};
use crate::whitening::NoiseModel;

/// Most effects that are named.
const MOST: usize = 8;
/// Most that are searched for, one of several harmonics of an effect as one.
const LONGEST: usize = 16;

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Seed of the draws by which chance is judged.
    pub seed: u64,
    /// Probability of a claim where there is nothing.
    pub level: f64,
    /// Whether the calibration that was fitted again is written also where no effect was found.
    pub refit: bool,
    /// A simulation to hold the recordings against, in the place of what calibration and model predict.
    pub against: Option<Document>,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 1, level: 0.01, refit: false, against: None }
    }
}

/// One thing that was found, and what was said against it.
#[derive(Clone, Debug)]
struct Found {
    refined: Refined,
    /// By how much it lowered the sum of squares when it came in.
    gain: f64,
    /// What was held against it.
    rivals: Rivals,
}

/// Where the search stands with so many names: before the first, and after each.
struct Stage {
    fit: Fit,
    noise: NoiseModel,
    /// What is left.
    look: Look,
}

/// All that was found.
struct Outcome {
    /// Residual of the document as it came, nT.
    before: Vec<f64>,
    /// The calibration alone fitted again.
    base: Fit,
    /// The noise on which that rests.
    base_noise: NoiseModel,
    /// The first look.
    first: Look,
    found: Vec<Found>,
    /// What else looked like an answer, and why it is none.
    refused: Vec<(String, String)>,
    /// The final fit.
    fit: Fit,
    noise: NoiseModel,
    /// The last look.
    last: Look,
}

/// Holds the recordings against the model and writes what is found to `diagnosis`, accepted effects to `model.effects` and the
/// calibration that goes with them to `calibration`.
pub fn run(document: Document, options: &Options) -> Result<Document, Error> {
    run_told(document, options, &|_| ())
}

/// The same; `told` hears what is being done.
pub fn run_told(mut document: Document, options: &Options, told: &dyn Fn(&str)) -> Result<Document, Error> {
    if !(options.level > 0.0 && options.level < 1.0) {
        return Err(common::Error::Request(format!(
            "a level of {}; expected a probability of false claims between 0 and 1, such as 0.01",
            options.level
        ))
        .into());
    }
    let original = match &options.against {
        Some(simulated) => against::against(&document, simulated)?,
        None => document.clone(),
    };
    let (model, start) = Model::of(&original, Observed::of(&original)?)?;
    let before = model.residual(&start)?;
    told("fitting the calibration again");
    let (base, base_noise) = settled(&original, &model, &start)?;
    let pool = Pool::of(&model, &base.state)?;
    let mut searcher = Searcher::new(&pool, options.seed, options.level);
    told(&format!("searching among {} candidates", pool.candidates.len()));
    let outcome = search(&original, &model, &mut searcher, before, (base, base_noise), told)?;
    told("writing the answer");
    let entry = report::report(&model, &mut searcher, &outcome, options)?;
    if matches!(entry.verdict, Verdict::Explained | Verdict::PartlyExplained) {
        adopt::adopt(&mut document, &model, &outcome);
    } else if options.refit && outcome.found.is_empty() {
        adopt::calibration(&mut document, &model, &outcome);
    }
    document.diagnosis = Some(vec![entry]);
    Ok(document)
}

fn search(
    document: &Document,
    model: &Model<'_>,
    searcher: &mut Searcher<'_>,
    before: Vec<f64>,
    (base, base_noise): (Fit, NoiseModel),
    told: &dyn Fn(&str),
) -> Result<Outcome, Error> {
    let first = searcher.look(&Fitter { model, noise: &base_noise }, &base)?;
    let mut stages = vec![Stage { fit: base.clone(), noise: base_noise.clone(), look: first.clone() }];
    let mut found: Vec<Found> = Vec::new();
    let mut refused = Vec::new();
    for proposal in lattice::proposals(document, model, &base_noise, &base) {
        told(&proposal.name);
        let Addition::Effect(effect) = &proposal.addition else { continue };
        // The codes are part of the noise, and act on nothing that is predicted.
        let acts = vec![false; model.observed.runs.len()];
        let state = model.with_acting(&stages[found.len()].fit.state, effect.clone(), acts);
        let (fit, noise) = settled(document, model, &state)?;
        let look = searcher.look(&Fitter { model, noise: &noise }, &fit)?;
        found.push(Found {
            gain: proposal.gain,
            refined: Refined::certain(proposal, fit.clone()),
            rivals: Rivals::default(),
        });
        stages.push(Stage { fit, noise, look });
    }
    while found.len() < LONGEST && distinct(&found) < MOST {
        let Stage { fit, noise, look } = &stages[found.len()];
        let fitter = Fitter { model, noise };
        let refined = searcher.refine(&fitter, fit, look)?;
        let Some(best) = best(&refined) else {
            refused = refined
                .iter()
                .filter_map(|r| Some((r.proposal.name.clone(), r.why_not.as_ref()?.words().into())))
                .collect();
            break;
        };
        told(&format!("{}; searching on", best.proposal.name));
        let (next, next_noise) = settled(document, model, &best.fit.state)?;
        let next_look = searcher.look(&Fitter { model, noise: &next_noise }, &next)?;
        found.push(Found {
            refined: best.clone(),
            gain: fit.cost - best.fit.cost,
            rivals: rivals(&fitter, fit, &refined, !next_look.clean(searcher.level))?,
        });
        stages.push(Stage { fit: next, noise: next_noise, look: next_look });
    }
    let kept = trust::kept(&found, &stages, searcher.level);
    if kept < found.len() {
        let why =
            "it does not explain far more than what is left, or what is left follows the same".to_string();
        refused.splice(0..0, found[kept..].iter().map(|f| (f.refined.proposal.name.clone(), why.clone())));
    }
    found.truncate(kept);
    let Stage { fit, noise, look: mut last } = stages.swap_remove(kept);
    if found.len() > 1 {
        for number in 0..found.len() {
            let fitter = Fitter { model, noise: &noise };
            let leaves = !last.clean(searcher.level);
            reconsider(&fitter, searcher, &base, &mut found, number, &fit, leaves)?;
        }
        last = searcher.look(&Fitter { model, noise: &noise }, &fit)?;
    }
    Ok(Outcome { before, base, base_noise, first, found, refused, fit, noise, last })
}

/// How many were found, the harmonics of one effect as one and each moment for itself.
fn distinct(found: &[Found]) -> usize {
    let (moments, others): (Vec<_>, Vec<_>) =
        found.iter().map(|one| &one.refined.proposal).partition(|proposal| proposal.local);
    moments.len() + others.into_iter().map(|proposal| &proposal.name).collect::<BTreeSet<_>>().len()
}

/// Looks at one of several found with the others in place: what they hid or feigned shows only then.
fn reconsider(
    fitter: &Fitter<'_, '_>,
    searcher: &mut Searcher<'_>,
    base: &Fit,
    found: &mut [Found],
    number: usize,
    fit: &Fit,
    leaves: bool,
) -> Result<(), Error> {
    let mut without = fit.state.clone();
    let before = |addition: fn(&Addition) -> bool| {
        found[..number].iter().filter(|f| addition(&f.refined.proposal.addition)).count()
    };
    match &found[number].refined.proposal.addition {
        Addition::Effect(_) => {
            let at = base.state.effects.len() + before(|a| matches!(a, Addition::Effect(_)));
            without.effects.remove(at);
            without.acts.remove(at);
        }
        Addition::Column(_) => {
            without.columns.remove(before(|a| matches!(a, Addition::Column(_))));
        }
    }
    let rest = fitter.refine(&without)?;
    let look = searcher.look(fitter, &rest)?;
    let refined = searcher.refine(fitter, &rest, &look)?;
    let Some(best) = best(&refined) else { return Ok(()) };
    if best.proposal.name == found[number].refined.proposal.name {
        found[number].rivals = rivals(fitter, &rest, &refined, leaves)?;
        let p_adjusted = found[number].refined.p_adjusted.min(best.p_adjusted);
        found[number].refined = Refined { p_adjusted, ..best.clone() };
    }
    Ok(())
}
