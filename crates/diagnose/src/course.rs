//! The course of a search: name after name until nothing is left or nothing fits, and which of them stand.

use common::Document;
use std::collections::BTreeSet;

use crate::fit::{Fit, Fitter, settled, square};
use crate::lattice;
use crate::model::{Model, State};
use crate::rivals::{Rivals, best, rivals};
use crate::search::{Addition, Refined, Searcher};
use crate::trust::Judge;
use crate::whitening::NoiseModel;
use crate::{Error, Found, Outcome, Stage};

/// Most effects that are named.
const MOST: usize = 8;
/// Most that are searched for, one of several harmonics of an effect as one.
const LONGEST: usize = 16;

/// What a name must do, squared and in standard deviations.
const SAID: f64 = 9.0;

/// Searches until nothing is left, nothing fits, or there is too much; then judges what was found.
pub fn search(
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
        let stage = at(document, model, searcher, &state)?;
        found.push(Found {
            gain: proposal.gain,
            gain_nt2: 0.0,
            refined: Refined::certain(proposal, stage.fit.clone()),
            rivals: Rivals::default(),
        });
        stages.push(stage);
    }
    let mut tried_first = Vec::new();
    while found.len() < LONGEST && distinct(&found) < MOST {
        let Choice { fit, noise, refined } = choose(document, model, searcher, &stages[found.len()])?;
        let Some(best) = best(&refined) else {
            refused = refined
                .iter()
                .filter_map(|r| Some((r.proposal.name.clone(), r.why_not.as_ref()?.words().into())))
                .collect();
            break;
        };
        told(&format!("{}; searching on", best.proposal.name));
        let next = at(document, model, searcher, &best.fit.state)?;
        let left = next.look.left(searcher.level);
        found.push(Found {
            refined: best.clone(),
            gain: fit.cost - best.fit.cost,
            gain_nt2: square(&fit.residual) - square(&best.fit.residual),
            rivals: rivals(&Fitter { model, noise: &noise }, &fit, &refined, left)?,
        });
        stages.push(next);
        if found.len() == 1 {
            tried_first = refined;
        }
    }
    let (kept, mut stage) = standing(document, model, searcher, &found, &mut stages)?;
    let fallen = (0..found.len()).filter(|number| !kept.contains(number));
    let why = "it does not explain far more than what is left, or what is left follows the same";
    let names = fallen.map(|number| (found[number].refined.proposal.name.clone(), why.to_string()));
    refused.splice(0..0, names);
    let mut numbers = 0..found.len();
    found.retain(|_| numbers.next().is_some_and(|number| kept.contains(&number)));
    if found.is_empty()
        && let Some((whole, with)) = whole(document, model, searcher, (&base, &base_noise), &tried_first)?
    {
        refused.clear();
        found.push(whole);
        stage = with;
    }
    while let Some(number) = silent(model, &found, &base, &stage)? {
        let state = without(&stage.fit.state, &base, &found, number);
        let one = found.remove(number);
        refused.push((one.refined.proposal.name, "without those that fell it has nothing to say".into()));
        stage = at(document, model, searcher, &state)?;
    }
    let Stage { fit, noise, look: mut last } = stage;
    if found.len() > 1 {
        for number in 0..found.len() {
            let fitter = Fitter { model, noise: &noise };
            let left = last.left(searcher.level);
            reconsider(&fitter, searcher, &base, &mut found, number, &fit, left)?;
        }
        last = searcher.look(&Fitter { model, noise: &noise }, &fit)?;
    }
    Ok(Outcome { before, base, base_noise, first, found, refused, fit, noise, last })
}

/// What may come in next, the best first, with the fit that it comes to and the noise by which it was judged.
struct Choice {
    fit: Fit,
    noise: NoiseModel,
    refined: Vec<Refined>,
}

/// Refines what a stage proposes. Where the noise is what a residual shows, what is looked for is a part of it: then what fits best is taken
/// out of it, and all are judged again by the noise that is left.
fn choose(
    document: &Document,
    model: &Model<'_>,
    searcher: &Searcher<'_>,
    stage: &Stage,
) -> Result<Choice, Error> {
    let judged = |fit: Fit, noise: NoiseModel| -> Result<Choice, Error> {
        let refined = searcher.refine(&Fitter { model, noise: &noise }, &fit, &stage.look)?;
        Ok(Choice { fit, noise, refined })
    };
    let first = judged(stage.fit.clone(), stage.noise.clone())?;
    let Some(one) = best(&first.refined).filter(|_| stage.noise.known == 0.0) else { return Ok(first) };
    let (_, noise) = settled(document, model, &one.fit.state)?;
    let fit = Fitter { model, noise: &noise }.refine(&stage.fit.state)?;
    let again = judged(fit, noise)?;
    Ok(if best(&again.refined).is_some() { again } else { first })
}

/// Which of those found stand where something is left, and the stage with them. A name that falls is taken out, the last first, and the
/// others are judged again without it.
fn standing(
    document: &Document,
    model: &Model<'_>,
    searcher: &mut Searcher<'_>,
    found: &[Found],
    stages: &mut Vec<Stage>,
) -> Result<(Vec<usize>, Stage), Error> {
    let judge = Judge { model, found, stages, level: searcher.level };
    let mut kept = judge.worth_keeping()?;
    loop {
        // The first so many: their stage was passed on the way.
        let passed = kept.iter().copied().eq(0..kept.len());
        let refitted =
            if passed { None } else { Some(with_only(document, model, searcher, (found, stages), &kept)?) };
        let now = refitted.as_ref().unwrap_or(&stages[kept.len()]);
        let whole = kept.len() == found.len() && now.look.clean(searcher.level);
        match judge.falls(&kept, now).filter(|_| !whole) {
            Some(falls) => kept.retain(|number| *number != falls),
            None => {
                let stage = refitted.unwrap_or_else(|| stages.swap_remove(kept.len()));
                return Ok((kept, stage));
            }
        }
    }
}

/// The stage with some of those found.
fn with_only(
    document: &Document,
    model: &Model<'_>,
    searcher: &mut Searcher<'_>,
    (found, stages): (&[Found], &[Stage]),
    kept: &[usize],
) -> Result<Stage, Error> {
    let fallen = (0..found.len()).rev().filter(|number| !kept.contains(number));
    let last = stages[found.len()].fit.state.clone();
    let state = fallen.fold(last, |state, number| without(&state, &stages[0].fit, found, number));
    at(document, model, searcher, &state)
}

/// The stage that a state comes to.
fn at(
    document: &Document,
    model: &Model<'_>,
    searcher: &mut Searcher<'_>,
    state: &State,
) -> Result<Stage, Error> {
    let (fit, noise) = settled(document, model, state)?;
    let look = searcher.look(&Fitter { model, noise: &noise }, &fit)?;
    Ok(Stage { fit, noise, look })
}

/// The last of those found that does no more at a stage than chance would: what it answered to has fallen. What is in the noise and not in the
/// prediction, as codes are, does nothing there.
fn silent(model: &Model<'_>, found: &[Found], base: &Fit, stage: &Stage) -> Result<Option<usize>, Error> {
    for number in (0..found.len()).rev() {
        let change = model.change(&without(&stage.fit.state, base, found, number), &stage.fit.state)?;
        let said = square(&stage.noise.whiten(&model.observed, &change));
        if said > 0.0 && said < SAID {
            return Ok(Some(number));
        }
    }
    Ok(None)
}

/// Of what was tried first, that which leaves nothing: where all that was found from the best one on falls, a name that explains everything
/// by itself says more, also where a simpler one said more of a part.
fn whole(
    document: &Document,
    model: &Model<'_>,
    searcher: &mut Searcher<'_>,
    (base, noise): (&Fit, &NoiseModel),
    tried: &[Refined],
) -> Result<Option<(Found, Stage)>, Error> {
    let (mut all, mut stage) = (Vec::new(), None);
    for one in tried.iter().filter(|one| one.why_not.is_none()) {
        let with = at(document, model, searcher, &one.fit.state)?;
        if with.look.clean(searcher.level) {
            all.push(one.clone());
            stage.get_or_insert(with);
        }
    }
    let (Some(first), Some(stage)) = (all.first(), stage) else { return Ok(None) };
    let rivals = rivals(&Fitter { model, noise }, base, &all, 0.0)?;
    let found = Found {
        gain: base.cost - first.fit.cost,
        gain_nt2: square(&base.residual) - square(&first.fit.residual),
        refined: first.clone(),
        rivals,
    };
    Ok(Some((found, stage)))
}

/// How many were found, the harmonics of one effect as one and each moment for itself.
fn distinct(found: &[Found]) -> usize {
    let (moments, others): (Vec<_>, Vec<_>) =
        found.iter().map(|one| &one.refined.proposal).partition(|proposal| proposal.local);
    moments.len() + others.into_iter().map(|proposal| &proposal.name).collect::<BTreeSet<_>>().len()
}

/// A state that has all that was found, without one of it.
pub fn without(state: &State, base: &Fit, found: &[Found], number: usize) -> State {
    let mut state = state.clone();
    let before = |addition: fn(&Addition) -> bool| {
        found[..number].iter().filter(|f| addition(&f.refined.proposal.addition)).count()
    };
    match &found[number].refined.proposal.addition {
        Addition::Effect(_) => {
            let at = base.state.effects.len() + before(|a| matches!(a, Addition::Effect(_)));
            state.effects.remove(at);
            state.acts.remove(at);
        }
        Addition::Column(_) => {
            state.columns.remove(before(|a| matches!(a, Addition::Column(_))));
        }
    }
    state
}

/// Looks at one of several found with the others in place: what they hid or feigned shows only then.
fn reconsider(
    fitter: &Fitter<'_, '_>,
    searcher: &mut Searcher<'_>,
    base: &Fit,
    found: &mut [Found],
    number: usize,
    fit: &Fit,
    left: f64,
) -> Result<(), Error> {
    let rest = fitter.refine(&without(&fit.state, base, found, number))?;
    let look = searcher.look(fitter, &rest)?;
    let refined = searcher.refine(fitter, &rest, &look)?;
    let Some(best) = best(&refined) else { return Ok(()) };
    if best.proposal.name == found[number].refined.proposal.name {
        found[number].rivals = rivals(fitter, &rest, &refined, left)?;
        let p_adjusted = found[number].refined.p_adjusted.min(best.p_adjusted);
        found[number].refined = Refined { p_adjusted, ..best.clone() };
    }
    Ok(())
}
