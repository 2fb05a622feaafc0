//! Long campaigns: the whole search is made on some of the rows, and what it weighed there is weighed on all.
//!
//! A search needs a thousand columns and more, of which fewer than a hundred are ever looked at beside others. Blocks of
//! rows that are spread over each recording tell which these are. Whatever happens at moments, at frequencies or in codes
//! is looked for in all rows.

use common::{Detectable, Document};
use estimate::screen::Chance;
use physics::{Acts, EffectInstance};

use crate::approach;
use crate::candidates::{Candidate, Kept};
use crate::course;
use crate::fit::{Fitter, settled, settled_near};
use crate::linear;
use crate::model::{Model, State, Unknown};
use crate::observed::Observed;
use crate::pool::Pool;
use crate::report::detectable_of_all;
use crate::search::Searcher;
use crate::what::What;
use crate::{Error, Options, Outcome};

/// Readings on which a longer campaign is screened, in blocks of so many rows of a recording.
const READINGS: usize = 4_096;
const BLOCK: usize = 256;
/// A campaign of no more than so many times as many readings is not screened.
const LONGER: usize = 2;

/// The search over the recordings of a model, and what it searched among.
pub fn search(
    document: &Document,
    (model, start): (&Model<'_>, &State),
    options: &Options,
    told: &dyn Fn(&str),
) -> Result<(Outcome, Searcher), Error> {
    let screened = Screened::of(document, model.observed.rows, options, told)?;
    searched(document, (model, start), screened.as_ref(), options, told)
}

/// What a search on some of the rows has found worth weighing.
struct Screened {
    kept: Kept,
    /// How great gains of all candidates are by chance.
    chance: Option<Chance>,
    /// The names of its answer.
    found: Vec<String>,
    /// The shapes to which fits came.
    shapes: Vec<EffectInstance>,
    /// The constants of the calibration fitted again.
    base: Vec<(Unknown, f64)>,
    /// What is to be said of its fits.
    notes: Vec<String>,
    /// What all rows could have shown.
    detectable: Vec<Detectable>,
}

impl Screened {
    /// Of a document; None where it has few readings, or where some of them say nothing.
    fn of(
        document: &Document,
        readings: usize,
        options: &Options,
        told: &dyn Fn(&str),
    ) -> Result<Option<Self>, Error> {
        if readings <= LONGER * READINGS {
            return Ok(None);
        }
        told("searching on some of the rows");
        let thin = thinned(document, READINGS as f64 / readings as f64);
        let (model, start) = Model::of(&thin, Observed::of(&thin)?)?;
        let (outcome, mut searcher) = match searched(&thin, (&model, &start), None, options, &|_| ()) {
            Err(Error::Unanswerable(_)) => return Ok(None),
            found => found?,
        };
        let fitter = Fitter { model: &model, noise: &outcome.noise };
        let mut detectable = detectable_of_all(&mut searcher, &outcome, &fitter, options)?;
        // In so many more readings a smaller size shows.
        let smaller = (model.observed.rows as f64 / readings as f64).sqrt();
        let sizes = detectable.iter_mut().flat_map(|one| one.smallest.values_mut());
        sizes.for_each(|size| *size *= smaller);
        let found = outcome.found.iter().map(|found| found.name.clone()).collect();
        let Searcher { pool, chance, mut kept, shapes, .. } = searcher;
        let candidates = pool.candidates.clone();
        // The plain regression has every column.
        let follows = |candidate: &Candidate| match &candidate.what {
            What::Physics(effect) => matches!(effect.kind.about().acts, Acts::WithColumn(_)),
            What::Smooth { .. } => false,
        };
        for (number, _) in candidates.iter().enumerate().filter(|(_, candidate)| follows(candidate)) {
            kept.entry(number).or_default().insert(0);
        }
        // With what neighbouring shapes do.
        for (number, shapes) in &mut kept {
            let beside = shapes.iter().flat_map(|shape| [shape.saturating_sub(1), shape + 1]);
            let beside: Vec<usize> =
                beside.filter(|shape| *shape < candidates[*number].trials.len()).collect();
            shapes.extend(beside);
        }
        let base = model.unknowns.iter().copied().zip(outcome.base.state.base).collect();
        let notes = outcome.notes;
        let kept = Kept { candidates, shapes: kept };
        Ok(Some(Self { kept, chance, found, shapes, base, notes, detectable }))
    }

    /// A state of a model with the constants that were found.
    fn begin(&self, model: &Model<'_>, start: &State) -> State {
        let of = |unknown: &Unknown| {
            self.base.iter().find(|(own, _)| own == unknown).map_or(0.0, |(_, value)| *value)
        };
        State { base: model.unknowns.iter().map(of).collect(), ..start.clone() }
    }
}

/// The search over the recordings of a model: among all that may explain them, or what was not screened out.
fn searched(
    document: &Document,
    (model, start): (&Model<'_>, &State),
    screened: Option<&Screened>,
    options: &Options,
    told: &dyn Fn(&str),
) -> Result<(Outcome, Searcher), Error> {
    let before = model.residual(start)?;
    told("refitting the calibration");
    let (base, base_noise) = match screened {
        Some(screened) => settled_near(document, model, &screened.begin(model, start))?,
        None => settled(document, model, start)?,
    };
    let notes = match screened {
        Some(screened) => screened.notes.clone(),
        None => linear::worse(model, start, (&base, &base_noise))?.into_iter().collect(),
    };
    let pools =
        |state: &State| Pool::of(model, state, &options.without, screened.map(|screened| &screened.kept));
    let searcher = |pool: Pool| {
        let mut own = Searcher::new(pool, options);
        if let Some(Screened { chance, shapes, detectable, .. }) = screened {
            own.chance.clone_from(chance);
            own.shapes.clone_from(shapes);
            own.detectable = Some(detectable.clone());
        }
        own
    };
    let mut all = searcher(pools(&base.state)?);
    told(&format!("searching among {} candidates", all.pool.candidates.len()));
    let mut near = approach::of(document, model, &mut all, (&base, &base_noise), &pools)?;
    let about = near.as_mut().and_then(|near| near.pool.take());
    let mut about = about.map(searcher);
    if let Some(near) = near {
        let own = about.as_mut().unwrap_or(&mut all);
        let found = near.search(document, model, own, before.clone(), (&base, &base_noise), told)?;
        if let Some(mut outcome) = found {
            outcome.notes.extend(notes);
            if let Some(about) = about {
                let first = std::mem::replace(&mut all, about);
                keep_too(&mut all, &first);
            }
            return Ok((outcome, all));
        }
    }
    let known = screened.map(|screened| screened.found.clone()).unwrap_or_default();
    let from = (base, base_noise);
    let mut outcome = course::search(document, model, &mut all, before, from, known, told)?;
    outcome.notes.extend(notes);
    Ok((outcome, all))
}

/// Keeps what another searcher, over a pool about another calibration, has kept.
fn keep_too(searcher: &mut Searcher, other: &Searcher) {
    for (number, shapes) in &other.kept {
        let key = other.pool.candidates[*number].key();
        let own = searcher.pool.candidates.iter().position(|candidate| candidate.key() == key);
        if let Some(own) = own {
            let tried = searcher.pool.candidates[own].trials.len();
            searcher.keep(shapes.iter().filter(|shape| **shape < tried).map(|shape| (own, *shape)));
        }
    }
}

/// A document with a share of the rows of each recording, in blocks.
fn thinned(document: &Document, share: f64) -> Document {
    let mut thin = document.clone();
    for recording in &mut thin.recordings {
        let rows = recording.rows();
        let most = ((rows as f64 * share) as usize).max(BLOCK).min(rows);
        let kept = explain::thinned(rows, most, (most / BLOCK).max(2));
        for column in recording.columns.values_mut() {
            *column = kept.iter().map(|row| column[*row]).collect();
        }
    }
    thin
}
