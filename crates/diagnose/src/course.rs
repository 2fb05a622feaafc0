//! The course of a diagnosis: a look, the sets of effects that explain what stands out, the best of them
//! fitted together with the calibration, and what stands out then.

use common::Verdict;
use physics::{EffectInstance, Kind, Stage};
use std::collections::BTreeSet;

use crate::additions::{at_shapes, columns_of, with_additions, without};
use crate::algebra::square;
use crate::atoms::{self, Atoms, Sizes};
use crate::codes;
use crate::decide::SURE;
use crate::events;
use crate::fit::{Fit, Fitter, settled};
use crate::form::Followed;
use crate::form_error;
use crate::level::Rest;
use crate::model::Model;
use crate::model::named;
use crate::pool::{fuller, simpler};
use crate::proposal::{Addition, Proposal, follow, fresh, grouped, insignificant, same};
use crate::search::Searcher;
use crate::sets::{Member, Sets};
use crate::stacked::Stacked;
use crate::verdict;
use crate::verdict::NamedEffect;
use crate::whitening::NoiseModel;
use crate::{Error, Ground, Outcome};

/// Most times that the search begins again with what stood out of its last answer.
const ROUNDS: usize = 8;
/// Rounds that find the same kinds of things go on while the sum of squares falls by more than this share.
const SETTLED: f64 = 0.02;
/// What names must do together with the calibration, over what they do where all is linear.
const MET: f64 = 0.5;
/// The catalogue's sizes are those of instruments that resolve this or less, nT.
const FINE_NT: f64 = 1.0;

impl Ground {
    /// How many effects and single readings it has, behind which those of an answer stand.
    fn counts(&self) -> (usize, usize) {
        (self.fit.state.effects.len(), self.fit.state.singles.len())
    }
}

/// Searches from names that are known, if any, fits, and judges.
pub fn search(
    searcher: &mut Searcher<'_, '_>,
    before: Vec<f64>,
    (fit, noise): (Fit, NoiseModel),
    mut known: Vec<String>,
) -> Result<Outcome, Error> {
    let (model, told) = (searcher.model, searcher.told);
    let base = searcher.ground(fit, noise)?;
    let origin = with_codes(searcher, &base)?;
    let found: Vec<NamedEffect> = origin.codes.iter().map(certain).collect();
    let mut outcome = Outcome {
        before,
        base,
        verdict: if found.is_empty() { Verdict::Agrees } else { Verdict::Explained },
        found,
        refused: Vec::new(),
        unnamed: Vec::new(),
        families: Vec::new(),
        now: origin.clone(),
        notes: Vec::new(),
        parameters: Vec::new(),
    };
    if origin.look.clean(searcher.level) {
        return Ok(outcome);
    }
    // With less noise where the names of a round explain some of what passed for it.
    let mut ground = origin;
    let mut events: Vec<Proposal> = ground.look.events.clone();
    // Those of them that turned out not to be significant beside the rest.
    let mut dropped: Vec<Proposal> = Vec::new();
    let mut round = 0;
    let mut before_this: Option<(BTreeSet<String>, f64)> = None;
    loop {
        told(&format!("comparing sets of effects, round {}", round + 1));
        let mut answer = weighed(searcher, &ground, &events, &known)?;
        known = answer.names.iter().map(|name| name.name.clone()).collect();
        let additions: Vec<Addition> = answer.names.iter().flat_map(|name| name.additions.clone()).collect();
        told("fitting the likeliest together with the calibration");
        let near = beside(model, &ground, &additions, None);
        let (fit, noise, left, cost) = match near.and_then(|fit| {
            let (left, cost) = (square(&fit.white[..fit.residual.len()]), fit.cost);
            let (fit, noise) = with_noise(model, &ground, fit)?;
            Ok((fit, noise, left, cost))
        }) {
            Err(Error::Unanswerable(_)) => {
                let now = outcome.now.clone();
                conclude(model, &mut outcome, answer.unexplained("no fit with it converges"), now)?;
                return Ok(outcome);
            }
            found => found?,
        };
        let met = square(&ground.fit.white[..fit.residual.len()]) - left > MET * answer.gain;
        let insignificant = insignificant(model, ground.counts(), (&fit, &noise), &additions, &events);
        let more = fresh(&answer.events, &[&events[..], &dropped].concat());
        round += 1;
        // Where the noise is what a residual shows, what was found is no longer a part of it.
        let from = ground.fit.state.effects.len();
        let mut sharper = moved(&fit.state.effects[from..], &mut searcher.shapes);
        sharper |= follow(&mut events, &additions, &fit.state.effects[from..]);
        if round <= REFITS && !searcher.is_second() {
            // What was fitted, each effect in turn in another form, and rivals whose shapes were not fitted yet.
            let mut known = shaped(&additions);
            let now = as_fitted(&additions, &fit.state.effects[from..]);
            let mut others = in_other_forms(&now);
            let forms = others.len();
            for rival in &answer.rivals {
                let own = shaped(rival);
                if !own.is_subset(&known) {
                    others.push(rival.clone());
                }
                known.extend(own);
            }
            let rows = fit.residual.len() as f64;
            let variance = (cost / rows).max(1.0);
            for (number, other) in others.iter().enumerate() {
                // A rival that has no minimum is none; one that is far behind is fitted no further.
                let Ok(fit) = beside(model, &ground, other, Some(cost + BEHIND * variance)) else { continue };
                let fitted = &fit.state.effects[from..];
                sharper |= moved(fitted, &mut searcher.shapes);
                // A line whose frequency wanders, by Schwarz's criterion.
                if number < forms && fit.cost < cost - rows.ln() * variance {
                    sharper |= follow(&mut events, &now, fitted);
                }
            }
        }
        let quieter = ground.noise.known == 0.0 && noise.variance() < 0.9 * ground.noise.variance();
        let now = (kinds(&additions), left);
        let settled =
            before_this.is_some_and(|before| before.0 == now.0 && left > (1.0 - SETTLED) * before.1);
        before_this = Some(now);
        // The shapes that some of the rows have shown are near enough to weigh by.
        let sharper = sharper && !searcher.is_second();
        let further = !settled && (!more.is_empty() || quieter || sharper);
        if round < ROUNDS && (further || !insignificant.is_empty()) {
            events.retain(|event| !insignificant.iter().any(|other| same(event, other)));
            events.extend(more);
            dropped.extend(insignificant);
            if quieter {
                let fit = Fitter { model, noise: &noise }.refine(&ground.fit.state)?;
                ground = Ground { codes: ground.codes, ..searcher.ground(fit, noise)? };
            }
            continue;
        }
        told("looking at what is left");
        if answer.nothing > 1.0 - SURE && !ground.look.exceeds(searcher.level) {
            answer = answer.agrees();
        } else if !met && !answer.names.is_empty() {
            answer = answer.unexplained("the joint fit does not confirm it");
        }
        let now = searcher.ground(fit, noise)?;
        told("judging each name");
        conclude(model, &mut outcome, answer, now)?;
        return Ok(outcome);
    }
}

/// A fit with the codes that the readings show by themselves, which are part of the noise.
fn with_codes(searcher: &mut Searcher<'_, '_>, base: &Ground) -> Result<Ground, Error> {
    let model = searcher.model;
    let mut codes = codes::coarse(model, &base.noise, &base.fit);
    codes.retain(|proposal| searcher.pool.considers(proposal));
    if codes.is_empty() {
        return Ok(base.clone());
    }
    let mut state = base.fit.state.clone();
    for proposal in &codes {
        if let Addition::Effect(effect) = &proposal.addition {
            state = model.with_acting(&state, effect.clone(), vec![false; model.observed.runs.len()]);
        }
    }
    let (fit, noise) = settled(model, &state, false)?;
    Ok(Ground { codes, ..searcher.ground(fit, noise)? })
}

/// What an answer consists of, whatever its shapes, sizes and moments.
fn kinds(additions: &[Addition]) -> BTreeSet<String> {
    let kind = |addition: &Addition| match addition {
        Addition::Effect(effect) => named(effect),
        Addition::Single(single) => single.what.clone(),
    };
    additions.iter().map(kind).collect()
}

/// What the readings show by themselves.
fn certain(proposal: &Proposal) -> NamedEffect {
    NamedEffect {
        name: proposal.name.clone(),
        additions: vec![proposal.addition.clone()],
        local: proposal.local,
        p: proposal.p,
        probability: 1.0,
        gain: proposal.gain,
        held_out: vec![0.0; crate::held_out::FOLDS],
        ..NamedEffect::default()
    }
}

/// Sets of atoms weighed on the ground of a search, from names that are known on, and what they say.
pub fn weighed(
    searcher: &mut Searcher<'_, '_>,
    ground: &Ground,
    events: &[Proposal],
    known: &[String],
) -> Result<verdict::Answer, Error> {
    let model = searcher.model;
    let fitter = &ground.fitter(model);
    let pool = searcher.pool.clone();
    let mut products = searcher.products(fitter).clone();
    let measure = Sizes {
        coarse: (fitter.resolution_nt(&ground.fit) / FINE_NT).max(1.0),
        noise_nt: fitter.noise.variance().sqrt(),
        residual_nt: (square(&ground.fit.residual) / ground.fit.residual.len().max(1) as f64).sqrt(),
    };
    let mut atoms = Atoms::of(&pool, &measure);
    for group in grouped(events) {
        let mut columns = Vec::new();
        let mut finite = false;
        for event in &group {
            let Some((own, is_finite)) = columns_of(model, &ground.fit.state, event)? else { continue };
            columns.extend(own);
            finite = is_finite;
        }
        let ranges = match group.first().map(|event| &event.addition) {
            Some(Addition::Effect(effect)) => {
                let own = atoms::ranges(effect, measure.coarse);
                own.iter().copied().cycle().take(columns.len()).collect()
            }
            _ => vec![[0.1 * measure.noise_nt, 1e5 * measure.noise_nt]; columns.len()],
        };
        if !columns.is_empty() {
            atoms.add_event(&group, columns, &ranges, finite);
        }
    }
    for effect in &searcher.shapes {
        let (columns, by_shape) = at_shapes(model, &ground.fit.state, effect)?;
        if columns.iter().chain(&by_shape).all(Stacked::is_finite) {
            atoms.add_fitted(effect, columns, by_shape);
        }
    }
    products.push(fitter.noise, atoms.more(), 0);
    let followed = Followed::of(model, &ground.fit.state)?;
    let screen = searcher.screen(fitter, &ground.fit)?;
    let mut sets = Sets::of(&atoms, fitter.noise, products, screen, followed);
    let ranked = sets.search(known);
    let tried = |member: &&Member| {
        pool.candidates.get(member.atom).is_some_and(|candidate| member.shape < candidate.shapes.len())
    };
    let weighed = ranked.iter().flat_map(|set| &set.members).filter(tried);
    searcher.keep(weighed.map(|member| (member.atom, member.shape)));
    let mut answer = verdict::answer(&sets, &ranked, searcher.level);
    let named = |member: &&Member| atoms.all[member.atom].is_named();
    let named: Vec<Member> = answer.members.iter().filter(named).cloned().collect();
    let best = answer.members.clone();
    // What stands out of all that was found; and beside the names alone, for structure without a name passes
    // for what happened at a moment.
    let beside = named.len() < best.len();
    for (whole, members) in std::iter::once((true, best)).chain(beside.then_some((false, named))) {
        let white = sets.residual(&members, &ground.fit.white);
        let residual = fitter.in_nt(&white);
        let left = Fit { white, residual, ..ground.fit.clone() };
        let rest = ground.look.rest.beside(0.0, sets.unknowns(&members));
        let rest = Rest { sum_of_squares: square(&left.white), ..rest };
        let more = if whole {
            searcher.events(fitter, &left, &rest)?.1
        } else {
            searcher.moments(fitter, &left, &rest)?
        };
        let more = fresh(&more, &answer.events);
        answer.events.extend(more);
    }
    Ok(answer)
}

/// Rounds in which rivals are fitted again.
const REFITS: usize = 2;
/// A rival is fitted as long as its sum of squares can come so near to the answer's, in variances of the noise.
const BEHIND: f64 = 60.0;
/// How much a shape must have moved, as a share, to be tried anew.
const MOVED: f64 = 0.02;

/// Adds the effects of a fit whose shapes are not among those that are known; whether there were any.
fn moved(fitted: &[EffectInstance], known: &mut Vec<EffectInstance>) -> bool {
    let mut any = false;
    for effect in fitted {
        let near = |other: &EffectInstance| {
            let (own, theirs) = (shapes(effect), shapes(other));
            other.is_same(effect)
                && theirs.len() == own.len()
                && theirs.iter().zip(&own).all(|(a, b)| (a / b - 1.0).abs() < MOVED)
        };
        if has_shape(effect) && !known.iter().any(near) {
            known.push(effect.clone());
            any = true;
        }
    }
    any
}

fn as_fitted(additions: &[Addition], fitted: &[EffectInstance]) -> Vec<Addition> {
    let mut effects = fitted.iter();
    let now = |addition: &Addition| match addition {
        Addition::Effect(effect) => Addition::Effect(effects.next().unwrap_or(effect).clone()),
        single => single.clone(),
    };
    additions.iter().map(now).collect()
}

/// Additions with one of their effects in a fuller form or as the simpler effect.
fn in_other_forms(additions: &[Addition]) -> Vec<Vec<Addition>> {
    let with = |(number, addition): (usize, &Addition)| {
        let forms = match addition {
            Addition::Effect(effect) => [fuller(effect), simpler(effect).filter(has_shape)],
            Addition::Single(_) => [None, None],
        };
        forms.into_iter().flatten().map(move |form| {
            let mut all = additions.to_vec();
            all[number] = Addition::Effect(form);
            all
        })
    };
    additions.iter().enumerate().flat_map(with).collect()
}

fn shapes(effect: &EffectInstance) -> Vec<f64> {
    let infos = effect.kind.parameters().iter().zip(&effect.parameters);
    infos.filter(|(info, value)| info.is_shape_at(**value)).map(|(_, value)| *value).collect()
}

/// Whether an effect has a shape that is the same in all recordings.
fn has_shape(effect: &EffectInstance) -> bool {
    effect.recording.is_none() && !shapes(effect).is_empty()
}

fn shaped(additions: &[Addition]) -> BTreeSet<String> {
    let of = |addition: &Addition| match addition {
        Addition::Effect(effect) if has_shape(effect) => Some(named(effect)),
        _ => None,
    };
    additions.iter().filter_map(of).collect()
}

/// The minimum with additions under the noise of the ground, or on the way where it cannot come to `reach`.
pub fn beside(
    model: &Model<'_>,
    ground: &Ground,
    additions: &[Addition],
    reach: Option<f64>,
) -> Result<Fit, Error> {
    let from = ground.fit.state.effects.len();
    let state = &model.with_past(with_additions(model, &ground.fit.state, additions), from)?;
    let fitter = ground.fitter(model);
    let hides = (state.effects[from..].iter())
        .any(|effect| effect.kind.about().stage == Stage::Converter || !effect.kind.invertible());
    let mut fit =
        if hides { fitter.refine(state)? } else { fitter.refine_near(state, &ground.fit, reach)? };
    for number in from..state.effects.len() {
        fit = events::settled_in_time(&fitter, fit, number)?;
    }
    Ok(fit)
}

/// A fit on the ground with the noise that it leaves, where that is not the ground's.
fn with_noise(model: &Model<'_>, ground: &Ground, fit: Fit) -> Result<(Fit, NoiseModel), Error> {
    let is_same = ground.noise.known > 0.0
        && ground.codes.is_empty()
        && fit.state.effects[ground.counts().0..].iter().all(|effect| effect.kind != Kind::Quantisation);
    if is_same { Ok((fit, ground.noise.clone())) } else { settled(model, &fit.state, false) }
}

/// Brings the last answer into an outcome that stands where the search began: what each name does beside the others.
fn conclude(
    model: &Model<'_>,
    outcome: &mut Outcome,
    answer: verdict::Answer,
    now: Ground,
) -> Result<(), Error> {
    outcome.verdict = answer.verdict;
    (outcome.refused, outcome.unnamed, outcome.families) = (answer.refused, answer.unnamed, answer.families);
    if matches!(answer.verdict, Verdict::Unexplained | Verdict::Agrees) {
        if !outcome.found.is_empty() {
            outcome.verdict = Verdict::PartlyExplained;
        }
        return Ok(());
    }
    let (fit, fitter) = (&now.fit, now.fitter(model));
    let mut from = outcome.now.counts();
    let departures = answer.names.iter().map(|name| (&name.additions[..], &name.departs[..]));
    let added = form_error::added(model, (fit, &now.noise), from.0, departures)?;
    let held_with = fitter.held_out(fit)?;
    for name in answer.names {
        let (state, next) = without(&fit.state, from, &name.additions);
        from = next;
        let rest = fitter.refine(&state)?;
        let held = fitter.held_out(&rest)?.parts.iter().zip(&held_with.parts).map(|(a, b)| a - b).collect();
        outcome.found.push(NamedEffect {
            gain: rest.cost - fit.cost,
            gain_nt2: square(&rest.residual) - square(&fit.residual),
            held_out: held,
            ..name
        });
    }
    outcome.now = Ground { fit: now.fit.widened(&added), ..now };
    Ok(())
}
