//! What physics did the model leave out? Predicts every recording from `calibration` and `model` and names
//! what explains the difference.
//!
//! Residuals are whitened by the noise as declared. Of every candidate and of the residual the base model's
//! columns are projected out, for the calibration has swallowed a part of every effect. A claim counts all
//! that was searched, shapes and moments included; it must predict readings that were left out, with
//! plausible sizes; and it is a name only where no rival fits as well. What is accepted is fitted together
//! with the calibration and goes to `model.effects`.
//!
//! - `observed` makes channels (`channel`) of the recordings. `model` has the unknowns (chain, levels, turns,
//!   effects, columns) with residual and derivatives from `predict_with_jacobian` (`model/step`: steps along
//!   which readings are linear). `whitening` is the noise, in one pass at any times; `fit` the minimum, and
//!   the prediction of held-out readings (`held_out`).
//! - `pool` and `generic` make columns of all `candidates`; `stacked` holds them channel by channel; `products`
//!   whitens them and forms the products that are asked for; `projection` takes out of them what a fit has unknown.
//! - `search` looks at one residual: what stands out, and its probability by chance. Chance is a bootstrap in
//!   whitened space (the maximum over all candidates and shapes), where the base fit is linear: a thousand
//!   whole searches for each recording would take hours and say the same. `lines`, `events` and `codes`
//!   search what no grid of columns can hold; `codes` sees coarse ones in the readings themselves, too.
//! - `atoms` are the possible explanations with their priors; `form` their departures from their equations
//!   (`form_error`: what these add to the uncertainty of every fitted parameter; `sized`: intervals of
//!   parameters). `evidence` is the marginal likelihood, `sets` the beam search over sets, `verdict` the
//!   names with probabilities and shares, `families` the kinds of physics. All thresholds are in `decide`.
//! - `plain` takes back names of impossible shapes, and judges names by held-out readings, beside plain
//!   regressions (`report/residuals`). `beside` answers of two instruments side by side.
//! - `course` iterates: sets, the best of them fitted with the calibration, what stands out of the new
//!   residual (`proposal`: which of it is new, which pays its trials factor). `approach`: where it
//!   begins, for large effects about the calibration that goes with them.
//! - `empirical` adopts structure without a name where that is asked for.
//! - `moved` tests the stated calibration against the fit. `experiment` varies a recording and finds the
//!   variant in which the rival names differ most. `report` and `adopt` write. `magnitude` compares a vector
//!   of unknown direction with a scalar reading, in the field of its own smooth readings. `covariates` says
//!   what an effect follows, for forms, places, energy and series alike.
//! - `joint`: constants that the recordings determine rest on the readings alone; the others keep their
//!   earlier sources of uncertainty.

mod additions;
mod adopt;
mod against;
mod algebra;
mod approach;
mod atoms;
mod beside;
mod candidates;
mod channel;
mod codes;
mod course;
mod covariates;
mod decide;
mod empirical;
mod events;
mod evidence;
mod experiment;
mod families;
mod fit;
mod form;
mod form_error;
mod generic;
mod held_out;
mod joint;
mod level;
mod lines;
mod magnitude;
mod model;
mod moved;
mod next;
mod observed;
mod plain;
mod pool;
mod products;
mod projection;
mod proposal;
mod report;
mod screened;
mod search;
mod sets;
mod sized;
mod stacked;
mod stands;
mod verdict;
mod waves;
mod whitening;
mod words;

pub use common::Error;
pub use words::summary;

use common::{Diagnosis, Document, ExplainedFamily, Quantity, Recording, Verdict, procedure};
use indexmap::IndexMap;
use physics::{Kind, References};

use crate::fit::{Fit, Fitter};
use crate::model::Model;
use crate::observed::Observed;
use crate::proposal::Proposal;
use crate::search::Look;
use crate::verdict::{NamedEffect, Unnamed};
use crate::whitening::NoiseModel;

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Seed of the random draws of the significance tests.
    pub seed: u64,
    /// Probability of a false alarm.
    pub level: f64,
    /// Whether the calibration that was fitted again is written also where no effect was found.
    pub refit: bool,
    /// A simulation to compare the recordings with, instead of the prediction of calibration and model.
    pub against: Option<Document>,
    /// Effects that are not considered, nor fuller forms of them.
    pub without: Vec<Kind>,
    /// Whether structure without a name is adopted as the effect `empirical`.
    pub empirical: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { seed: 1, level: 0.01, refit: false, against: None, without: Vec::new(), empirical: false }
    }
}

/// A fit with the noise on which it rests, and what stands out of it.
#[derive(Clone)]
struct Ground {
    fit: Fit,
    noise: NoiseModel,
    look: Look,
    /// Codes that the readings show by themselves.
    codes: Vec<Proposal>,
}

impl Ground {
    fn fitter<'b, 'a>(&'b self, model: &'b Model<'a>) -> Fitter<'a, 'b> {
        Fitter { model, noise: &self.noise }
    }
}

/// All that was found.
struct Outcome {
    /// Residual of the document as it came, nT.
    before: Vec<f64>,
    base: Ground,
    /// The final fit.
    now: Ground,
    found: Vec<NamedEffect>,
    verdict: Verdict,
    refused: Vec<(String, String)>,
    /// Structure without a name beside them.
    unnamed: Vec<Unnamed>,
    /// The kinds of physics among all of it.
    families: Vec<ExplainedFamily>,
    /// What is to be said of the fits.
    notes: Vec<String>,
    /// Parameters of the effects of the final fit, with their uncertainty.
    parameters: Vec<IndexMap<String, Quantity>>,
}

impl Outcome {
    /// Takes back its names, for a reason.
    fn without_names(&mut self, why: &str) {
        self.refused.extend(self.found.drain(..).map(|found| (found.name, why.to_string())));
        self.verdict = Verdict::Unexplained;
        self.now = self.base.clone();
    }
}

/// The plan of the recording that would decide an ambiguous answer, as text for `simulate campaign`.
pub fn plan(document: &Document) -> Option<String> {
    let entries = document.diagnosis.iter().flatten();
    let plan =
        entries.flat_map(|entry| &entry.experiments).find_map(|experiment| experiment.plan.as_ref())?;
    Some(common::to_text(plan))
}

/// Holds the recordings against the model and writes what is found to `diagnosis`, accepted effects to
/// `model.effects` and the calibration that goes with them to `calibration`.
pub fn run(document: Document, options: &Options) -> Result<Document, Error> {
    run_told(document, options, &|_| ())
}

/// The same; `told` hears what is being done.
pub fn run_told(mut document: Document, options: &Options, told: &dyn Fn(&str)) -> Result<Document, Error> {
    if !(options.level > 0.0 && options.level < 1.0) {
        return Err(Error::Request(format!(
            "a level of {}; expected a probability of false claims between 0 and 1, such as 0.01",
            options.level
        )));
    }
    let pair = |recording: &Recording| recording.procedure == procedure::DIFFERENTIAL;
    let pairs = document.recordings.iter().filter(|recording| pair(recording)).count();
    let alone = pairs > 0 && pairs == document.recordings.len();
    let mut entries = Vec::new();
    let mut notes = Vec::new();
    if pairs > 0 {
        match beside::pairs(&mut document, options, told) {
            Ok(entry) => entries.push(all_considered(entry, options)),
            Err(error) if alone => return Err(error),
            Err(error) => {
                notes.push(format!("note: nothing is said of the instruments side by side: {error}"))
            }
        }
    }
    if !alone {
        let entry = match beside::magnitude(&mut document, options, told)? {
            Some(entry) => all_considered(entry, options),
            None => campaign(&mut document, options, told)?,
        };
        entries.push(Diagnosis { reasons: [entry.reasons, notes].concat(), ..entry });
    }
    for effect in entries.iter_mut().flat_map(|entry| &mut entry.effects) {
        if let Some(kind) = Kind::named(&effect.effect) {
            effect.family = kind.about().family.word().into();
        }
    }
    document.diagnosis = Some(entries);
    Ok(document)
}

/// Says that no effect was left out beside another instrument, and nothing adopted without a name.
fn all_considered(mut entry: Diagnosis, options: &Options) -> Diagnosis {
    if options.empirical {
        entry.reasons.push("note: --empirical adopts nothing beside another instrument".into());
    }
    if !options.without.is_empty() {
        let names: Vec<&str> = options.without.iter().map(|kind| kind.name()).collect();
        entry.reasons.push(format!(
            "note: --without {} leaves nothing out beside another instrument: remove the column that it follows from the recording",
            names.join(" ")
        ));
    }
    entry
}

/// All recordings but those of instruments side by side, against the model.
fn campaign(document: &mut Document, options: &Options, told: &dyn Fn(&str)) -> Result<Diagnosis, Error> {
    let original = match &options.against {
        Some(simulated) => against::against(document, simulated)?,
        None => document.clone(),
    };
    let gathered = joined::gathered(&original)?;
    let notes = gathered.iter().flat_map(|gathered| &gathered.told).map(|told| told.words.clone());
    let notes: Vec<String> = notes.collect();
    let original = gathered.map_or(original, |gathered| gathered.document);
    let mut observed = Observed::of(&original)?;
    observed.notes.splice(0..0, notes);
    let (model, start) = Model::of(observed)?;
    let (mut outcome, mut searcher) = screened::search(&model, &start, options, told)?;
    told("writing the answer");
    stands::standing(&model, &start, &mut outcome)?;
    plain::judge_shapes(&model, &mut outcome);
    let mut fit = report::fit(&mut searcher, &outcome)?;
    if plain::judge(&mut outcome, &fit) {
        fit = report::fit(&mut searcher, &outcome)?;
    }
    let empirical = if options.empirical {
        told("adopting structure without a name");
        empirical::adopt(&mut searcher, &mut outcome)?
    } else {
        Vec::new()
    };
    if !empirical.is_empty() {
        fit = report::fit(&mut searcher, &outcome)?;
    }
    let moved = moved::moved(&model, &outcome, options.level);
    if outcome.verdict == Verdict::Agrees && !moved.is_empty() {
        outcome.verdict = Verdict::Explained;
    }
    outcome.parameters = report::quantities(&model, &outcome);
    let named = match outcome.verdict {
        Verdict::Explained | Verdict::PartlyExplained => true,
        Verdict::Ambiguous => options.empirical,
        Verdict::Agrees | Verdict::Unexplained => false,
    };
    if outcome.verdict == Verdict::Ambiguous && named {
        let likeliest: Vec<&str> = outcome.found.iter().map(|found| found.name.as_str()).collect();
        let note = "of names that cannot be told apart --empirical adopts the likeliest";
        outcome.notes.push(format!("{note}: {}", likeliest.join(", ")));
    }
    if named || !empirical.is_empty() {
        outcome.parameters = adopt::adopt(document, &model, &outcome)?;
        physics::state_references(document, &References::of(&original));
    } else if options.refit {
        // Beside names that are open, without any of them.
        let stands = if outcome.found.is_empty() { &outcome.now } else { &outcome.base };
        adopt::calibration(document, &model, stands)?;
    }
    let entry = report::report(&mut searcher, &outcome, fit)?;
    let entry = Diagnosis { calibration_moved: moved, empirical, ..entry };
    Ok(Diagnosis { answer: words::answer(&entry), ..entry })
}
