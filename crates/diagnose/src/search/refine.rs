//! Proposals fitted together with all else, and why some are not taken.

use common::number::{duration, significant};
use physics::{EffectInstance, Kind, Role, Stage};
use rayon::prelude::*;

use super::{Addition, FAMILIES, Look, Proposal, Searcher};
use crate::Error;
use crate::candidates::{What, named};
use crate::dependence;
use crate::events;
use crate::fit::{Fit, Fitter};
use crate::held_out::FOLDS;
use crate::level::at_least_one;
use crate::model::State;
use crate::rivals;

/// Candidates that are refined at each step.
const REFINED: usize = 8;
/// A size may be beyond its plausible range by this factor.
const BEYOND: f64 = 3.0;
/// The catalogue's sizes are those of instruments that resolve this or less, nT; of a coarser one they are larger in proportion.
const FINE_NT: f64 = 1.0;
/// Longest pass of a vehicle, as a share of its recording: a longer one is a drift.
const LONGEST_PASS: f64 = 0.2;

/// A proposal fitted together with all else.
#[derive(Clone, Debug)]
pub struct Refined {
    /// The proposal.
    pub proposal: Proposal,
    /// Probability by chance, all families.
    pub p_adjusted: f64,
    /// The fit with it.
    pub fit: Fit,
    /// Unknowns that it brings.
    pub unknowns: f64,
    /// Deviance: −2 ln likelihood up to a constant.
    pub deviance: f64,
    /// Σ of squares of rows left out by part: without it less with it.
    pub held_out: Vec<f64>,
    /// Why it is not taken; None where it may be.
    pub why_not: Option<Fault>,
}

/// Why something is not taken.
#[derive(Clone, Debug)]
pub enum Fault {
    /// It adds nothing that a simpler effect does not say, or does not fit.
    Idle(String),
    /// It fits, with a size that is not plausible: whatever fits worse is no answer either.
    Implausible(String),
}

impl Fault {
    /// In words.
    pub fn words(&self) -> &str {
        match self {
            Fault::Idle(words) | Fault::Implausible(words) => words,
        }
    }
}

impl Refined {
    /// What the readings show by themselves, in the fit with it.
    pub fn certain(proposal: Proposal, fit: Fit) -> Self {
        Self {
            p_adjusted: at_least_one(proposal.p, FAMILIES),
            unknowns: proposal.searched,
            deviance: fit.cost,
            held_out: vec![0.0; FOLDS],
            why_not: None,
            proposal,
            fit,
        }
    }

    /// Bayes' information criterion: deviance and ln n for each unknown.
    pub fn criterion(&self) -> f64 {
        self.deviance + self.unknowns * (self.fit.white.len() as f64).ln()
    }
}

/// An effect with a lag without it, where that is not proposed by itself: a lag of nothing is among the shapes that were tried.
fn simpler(proposal: &Proposal, state: &State, proposals: &[Proposal]) -> Option<Proposal> {
    let Addition::Effect(lagged) = &proposal.addition else { return None };
    let kind = rivals::without_lag(lagged.kind)?;
    let mut effect =
        EffectInstance { kind, parameters: vec![0.0; kind.parameters().len()], ..lagged.clone() };
    for (value, from) in effect.parameters.iter_mut().zip(&lagged.parameters[..lagged.parameters.len() - 1]) {
        *value = *from;
    }
    let name = named(&effect);
    let there = proposals.iter().any(|other| other.name == name)
        || state.effects.iter().any(|other| named(other) == name);
    (!there).then(|| Proposal { name, addition: Addition::Effect(effect), ..proposal.clone() })
}

impl Searcher<'_> {
    /// The most promising proposals fitted together with all else, the best first.
    pub fn refine(&self, fitter: &Fitter<'_, '_>, fit: &Fit, look: &Look) -> Result<Vec<Refined>, Error> {
        let before = fitter.held_out(fit)?;
        let one = |proposal: &Proposal| -> Result<Option<Refined>, Error> {
            let state = match &proposal.addition {
                Addition::Effect(effect) => fitter.model.with(&fit.state, effect.clone()),
                Addition::Column(column) => {
                    let mut state = fit.state.clone();
                    state.columns.push(dependence::with_lag(fitter, fit, column)?);
                    state
                }
            };
            let hides = |effect: &EffectInstance| {
                let about = effect.kind.about();
                about.stage == Stage::Converter || !about.invertible
            };
            let with = match &proposal.addition {
                Addition::Effect(effect) if hides(effect) => fitter.refine(&state),
                _ => fitter.refine_near(&state, fit),
            };
            let Ok(with) = with else { return Ok(None) };
            let with = if proposal.local { events::settled_in_time(fitter, with)? } else { with };
            let held_out: Vec<f64> = before
                .parts
                .iter()
                .zip(fitter.held_out(&with)?.parts)
                .map(|(before, after)| before - after)
                .collect();
            let deviance = match fitter.noise.known {
                known if known.is_infinite() => with.cost,
                known => (known + look.rest.freedom) * (known + with.cost).max(f64::MIN_POSITIVE).ln(),
            };
            let unknowns = with.determined - fit.determined + proposal.searched;
            let why_not = self.why_not(fitter, proposal, fit, &with, &held_out, look);
            Ok(Some(Refined {
                p_adjusted: at_least_one(proposal.p, FAMILIES),
                proposal: proposal.clone(),
                fit: with,
                unknowns,
                deviance,
                held_out,
                why_not,
            }))
        };
        let promising = &look.proposals[..look.proposals.len().min(REFINED)];
        let simpler: Vec<Proposal> =
            promising.iter().filter_map(|proposal| simpler(proposal, &fit.state, &look.proposals)).collect();
        let all: Vec<&Proposal> = promising.iter().chain(&simpler).collect();
        let refined: Vec<Option<Refined>> =
            all.par_iter().map(|proposal| one(proposal)).collect::<Result<_, Error>>()?;
        let mut all: Vec<Refined> = refined.into_iter().flatten().collect();
        rivals::without_needless_lags(fitter, &mut all);
        rivals::without_mere_parts(&mut all);
        all.sort_by(|a, b| {
            a.why_not.is_some().cmp(&b.why_not.is_some()).then(a.criterion().total_cmp(&b.criterion()))
        });
        Ok(all)
    }

    /// Why a refined proposal cannot be taken: sizes that are not plausible, shapes that ran away, rows left out that are not met.
    fn why_not(
        &self,
        fitter: &Fitter<'_, '_>,
        proposal: &Proposal,
        before: &Fit,
        with: &Fit,
        held_out: &[f64],
        look: &Look,
    ) -> Option<Fault> {
        let idle = |words: String| Some(Fault::Idle(words));
        let gain = before.cost - with.cost;
        let rank = with.rank.saturating_sub(before.rank);
        let unfitted = matches!(&proposal.addition, Addition::Effect(e) if [Kind::Quantisation, Kind::Dropout].contains(&e.kind));
        if (rank == 0 && !unfitted) || gain < 0.3 * proposal.gain.min(look.rest.sum_of_squares) {
            return idle("it does not fit once everything is fitted together".into());
        }
        if let Addition::Effect(_) = &proposal.addition {
            let (found, others) = with.state.effects.split_last()?;
            if let Some(fault) = self.odd(fitter, with, found) {
                return Some(fault);
            }
            // Two that cancel can be of any size: what one says is then said against the other.
            for (now, then) in others.iter().zip(&before.state.effects) {
                if let (Some(fault), None) = (self.odd(fitter, with, now), self.odd(fitter, before, then)) {
                    return idle(format!("beside it, of {}: {}", named(now), fault.words()));
                }
            }
        }
        let total: f64 = held_out.iter().sum();
        if !proposal.local && total <= 0.0 {
            return idle("it does not predict readings that were left out".into());
        }
        None
    }

    /// What is odd about the sizes and shapes of an effect in a fit.
    fn odd(&self, fitter: &Fitter<'_, '_>, with: &Fit, found: &EffectInstance) -> Option<Fault> {
        let idle = |words: String| Some(Fault::Idle(words));
        let coarse = (fitter.resolution_nt(with) / FINE_NT).max(1.0);
        if let (Kind::VehiclePass, [.., duration_s]) = (found.kind, &found.parameters[..])
            && *duration_s > LONGEST_PASS * fitter.model.observed.longest_s()
        {
            return idle(format!("a pass of {} does not end within its recording", duration(*duration_s)));
        }
        if let (Kind::CoilHeating, [brought, before, ..]) = (found.kind, &found.parameters[..])
            && brought * before < 0.0
            && before.abs() > brought.abs()
        {
            return idle("the warmth of before would have to act against what the current brings".into());
        }
        // Without an amplitude a small shape is a small effect.
        let sized = found.kind.parameters().iter().any(|info| info.role == Role::Amplitude);
        for (info, value) in found.kind.parameters().iter().zip(&found.parameters) {
            let beyond = match info.role {
                Role::Amplitude if info.name.contains("nt") => value.abs() > BEYOND * coarse * info.high,
                Role::Amplitude => value.abs() > BEYOND * info.high,
                Role::Shape => *value > BEYOND * info.high || sized && *value < info.low / BEYOND,
                Role::Epoch => false,
            };
            if beyond {
                let words = format!(
                    "{} would have to be {}, which is not plausible",
                    info.name,
                    significant(*value, 3)
                );
                let amplitude = info.role == Role::Amplitude;
                return Some(if amplitude { Fault::Implausible(words) } else { Fault::Idle(words) });
            }
        }
        let mut candidates = self.pool.candidates.iter();
        let candidate =
            candidates.find(|c| matches!(&c.what, What::Physics(e) if named(e) == named(found)))?;
        let at = found.kind.parameters().iter().position(|info| info.role == Role::Shape)?;
        if candidate.finite {
            return None;
        }
        // An inflection is seen from both sides.
        let slack = if found.kind == Kind::OffsetTemperatureInflection { 0.0 } else { 0.1 };
        let tried: Vec<f64> = candidate.trials.iter().filter_map(|trial| trial.shape).collect();
        let (low, high) = tried.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), s| (l.min(*s), h.max(*s)));
        let name = found.kind.parameters()[at].name;
        if found.parameters[at] < (1.0 - slack) * low {
            return idle(format!("{name} runs to nothing, where a simpler effect says the same"));
        }
        if found.parameters[at] > (1.0 + slack) * high {
            return idle(format!(
                "{name} runs beyond what the recording spans, where a simpler effect says the same"
            ));
        }
        None
    }
}
