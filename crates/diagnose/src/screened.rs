//! Long campaigns: the whole search is made on some of the rows, and what it weighed there is weighed on all.
//!
//! A search needs a thousand columns and more, of which fewer than a hundred are ever looked at beside others. Blocks of
//! rows that are spread over each recording tell which these are. Whatever happens at moments, at frequencies or in codes
//! is looked for in all rows.

use common::number::significant;
use common::{Detectable, Document, PlainRegression};
use estimate::screen::Chance;
use physics::{Acts, EffectInstance};

use crate::approach;
use crate::candidates::{Candidate, Kept};
use crate::course;
use crate::fit::{Fit, Fitter, settled};
use crate::model::{Model, State, Unknown};
use crate::observed::Observed;
use crate::pool::Pool;
use crate::projection::Projection;
use crate::proposal::What;
use crate::report::detectable_of_all;
use crate::search::Searcher;
use crate::whitening::NoiseModel;
use crate::{Error, Options, Outcome};

/// Readings on which a longer campaign is screened, in blocks of so many rows of a recording.
const READINGS: usize = 4_096;
const BLOCK: usize = 256;
/// A campaign of no more than so many times as many readings is not screened.
const LONGER: usize = 2;

/// The search over the recordings of a model, and what it searched among.
pub fn search<'m, 'a>(
    model: &'m Model<'a>,
    start: &State,
    options: &Options,
    told: &'m dyn Fn(&str),
) -> Result<(Outcome, Searcher<'m, 'a>), Error> {
    let screened = Screened::of(model, options, told)?;
    searched(model, start, screened.as_ref(), options, told)
}

/// What a search on some of the rows has found worth weighing.
struct Screened {
    kept: Kept,
    /// How great gains of all candidates are by chance.
    chance: Option<Chance>,
    found: Vec<String>,
    shapes: Vec<EffectInstance>,
    /// The constants of the calibration fitted again.
    base: Vec<(Unknown, f64)>,
    /// What is to be said of its fits.
    notes: Vec<String>,
    /// What all rows could have shown.
    detectable: Vec<Detectable>,
}

impl Screened {
    /// None where there are few readings, or where some of them say nothing.
    fn of(all: &Model<'_>, options: &Options, told: &dyn Fn(&str)) -> Result<Option<Self>, Error> {
        let readings = all.observed.rows;
        if readings <= LONGER * READINGS {
            return Ok(None);
        }
        told("searching on some of the rows");
        let thin = thinned(all.observed.document, READINGS as f64 / readings as f64);
        let (model, start) = Model::of(Observed::of(&thin)?)?;
        let (outcome, mut searcher) = match searched(&model, &start, None, options, &|_| ()) {
            Err(Error::Unanswerable(_)) => return Ok(None),
            found => found?,
        };
        let mut detectable = detectable_of_all(&mut searcher, &outcome)?;
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
            _ => false,
        };
        for (number, _) in candidates.iter().enumerate().filter(|(_, candidate)| follows(candidate)) {
            kept.entry(number).or_default().insert(0);
        }
        // With what neighbouring shapes do.
        for (number, shapes) in &mut kept {
            let beside = shapes.iter().flat_map(|shape| [shape.saturating_sub(1), shape + 1]);
            let beside: Vec<usize> =
                beside.filter(|shape| *shape < candidates[*number].shapes.len()).collect();
            shapes.extend(beside);
        }
        let base = model.unknowns.iter().copied().zip(outcome.base.fit.state.base).collect();
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
fn searched<'m, 'a>(
    model: &'m Model<'a>,
    start: &State,
    screened: Option<&Screened>,
    options: &Options,
    told: &'m dyn Fn(&str),
) -> Result<(Outcome, Searcher<'m, 'a>), Error> {
    let before = model.residual(start)?;
    told("refitting the calibration");
    let (base, base_noise) = match screened {
        Some(screened) => settled(model, &screened.begin(model, start), true)?,
        None => settled(model, start, false)?,
    };
    let notes = match screened {
        Some(screened) => screened.notes.clone(),
        None => worse(model, start, (&base, &base_noise))?.into_iter().collect(),
    };
    let pools =
        |state: &State| Pool::of(model, state, &options.without, screened.map(|screened| &screened.kept));
    let searcher = |pool: Pool| {
        let mut own = Searcher::new(model, pool, options, told);
        if let Some(Screened { chance, shapes, detectable, .. }) = screened {
            own.chance.clone_from(chance);
            own.shapes.clone_from(shapes);
            own.detectable = Some(detectable.clone());
        }
        own
    };
    let mut all = searcher(pools(&base.state)?);
    told(&format!("searching among {} candidates", all.pool.candidates.len()));
    let mut near = approach::of(&mut all, (&base, &base_noise), &pools)?;
    let about = near.as_mut().and_then(|near| near.pool.take());
    let mut about = about.map(searcher);
    if let Some(near) = near {
        let own = about.as_mut().unwrap_or(&mut all);
        let found = near.search(own, before.clone(), (&base, &base_noise))?;
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
    let mut outcome = course::search(&mut all, before, from, known)?;
    outcome.notes.extend(notes);
    Ok((outcome, all))
}

/// Keeps what another searcher, over a pool about another calibration, has kept.
fn keep_too(searcher: &mut Searcher<'_, '_>, other: &Searcher<'_, '_>) {
    for (number, shapes) in &other.kept {
        let key = other.pool.candidates[*number].key();
        let own = searcher.pool.candidates.iter().position(|candidate| candidate.key() == key);
        if let Some(own) = own {
            let tried = searcher.pool.candidates[own].shapes.len();
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

/// What to say of a fit that leaves more than linear least squares at its start, under the same noise.
fn worse(
    model: &Model<'_>,
    start: &State,
    (fit, noise): (&Fit, &NoiseModel),
) -> Result<Option<String>, Error> {
    let begun = Fitter { model, noise }.at(start)?;
    let linear = Projection::of(&begun)?.screen().sum_of_squares();
    let ratio = if linear > 0.0 { (fit.cost / linear).sqrt() } else { 1.0 };
    Ok((ratio > PlainRegression::WORSE).then(|| {
        format!(
            "the calibration fitted again leaves {} times the residual of linear least squares of the same constants: it did not converge; give a calibration nearer to the true one",
            significant(ratio, 3)
        )
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fit_that_stays_where_it_began_is_told() {
        let document =
            Document::parse(&testkit::read_fixture("diagnose/warm/input.json")).expect("a document");
        let (model, start) = Model::of(Observed::of(&document).expect("read")).expect("a model");
        let (fit, noise) = settled(&model, &start, false).expect("fitted");
        assert_eq!(worse(&model, &start, (&fit, &noise)).expect("compared"), None);
        let stays = Fitter { model: &model, noise: &noise }.at(&start).expect("finite");
        let words = worse(&model, &start, (&stays, &noise)).expect("compared").expect("words");
        assert!(words.contains("did not converge"), "{words}");
    }
}
