//! The search: which candidates explain what is left, how sure that is, and which fit equally well.

use estimate::screen::{Chance, Screen, Search};
use faer::Mat;
use noise::Stream;
use physics::{EffectInstance, Kind, Role};
use rayon::prelude::*;

use crate::Error;
use crate::candidates::{Candidate, Pool, What, named};
use crate::codes;
use crate::dependence::{self, Follows};
use crate::events;
use crate::fit::{Fit, Fitter};
use crate::level::{Rest, at_least_one};
use crate::lines::{self, Line};
use crate::model::{Column, State};
use crate::rivals;
use crate::whitening::NoiseModel;
use std::sync::Arc;

/// Draws of the distribution by chance.
const DRAWS: usize = 399;
/// Families of candidates that are searched apart: grids, lines, events, codes, the size of what is left.
const FAMILIES: f64 = 5.0;
/// Candidates that are refined at each step.
const REFINED: usize = 8;
/// A size may be beyond its plausible range by this factor.
const BEYOND: f64 = 3.0;

/// What comes into the model.
#[derive(Clone, Debug)]
pub enum Addition {
    /// An effect.
    Effect(EffectInstance),
    /// A column.
    Column(Column),
}

/// Something that may explain what is left, before it is refined.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// Its name with its target.
    pub name: String,
    /// What comes in.
    pub addition: Addition,
    /// Probability by chance within its family, the search included.
    pub p: f64,
    /// By how much it lowers the sum of squares.
    pub gain: f64,
    /// Unknowns that were found by search besides those that are fitted.
    pub searched: f64,
    /// Whether it touches few rows, so that rows left out say nothing.
    pub local: bool,
}

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
    /// Bayes' information criterion: deviance and ln n for each unknown.
    pub fn criterion(&self) -> f64 {
        self.deviance + self.unknowns * (self.fit.white.len() as f64).ln()
    }
}

/// Structure that smooth functions find.
#[derive(Clone, Debug)]
pub struct Structure {
    /// What follows what.
    pub what: What,
    /// Probability by chance, all families.
    pub p_adjusted: f64,
    /// By how much it lowers the sum of squares.
    pub gain: f64,
    /// Its unknowns.
    pub unknowns: f64,
}

/// What one look at a residual gave.
#[derive(Clone, Debug)]
pub struct Look {
    /// What is left before anything comes in.
    pub rest: Rest,
    /// Proposals below the level, the least probable first.
    pub proposals: Vec<Proposal>,
    /// What follows smooth functions of something, the most striking first.
    pub structures: Vec<Structure>,
    /// The strongest line.
    pub line: Option<Line>,
    /// Smallest probability of all, families counted.
    pub least_p: f64,
}

impl Look {
    /// Whether nothing is left but the noise.
    pub fn clean(&self, level: f64) -> bool {
        self.least_p >= level && self.rest.omnibus().is_none_or(|p| at_least_one(p, FAMILIES) >= level)
    }

    /// By how much what is left would lower the sum of squares if it had a name.
    pub fn left(&self) -> f64 {
        let excess = self.rest.sum_of_squares - self.rest.freedom * self.rest.scale();
        let structured = self.structures.iter().map(|s| s.gain);
        structured.chain(self.proposals.iter().map(|p| p.gain)).fold(excess.max(0.0), f64::max)
    }
}

/// A search over one pool of candidates.
pub struct Searcher<'p> {
    pool: &'p Pool,
    /// The pool whitened, and the noise that whitened it.
    white: Option<(NoiseModel, Vec<Vec<f64>>)>,
    chance: Option<Chance>,
    seed: u64,
    /// Probability of a claim where there is nothing.
    pub level: f64,
}

impl<'p> Searcher<'p> {
    /// Over a pool, claims at a level.
    pub fn new(pool: &'p Pool, seed: u64, level: f64) -> Self {
        Self { pool, white: None, chance: None, seed, level }
    }

    /// The candidates.
    pub fn candidates(&self) -> &[Candidate] {
        &self.pool.candidates
    }

    /// The probability of one shape of a candidate at which it is claimed.
    pub fn threshold(&self, candidate: usize, level: f64) -> f64 {
        self.chance.as_ref().map_or(level, |chance| chance.threshold(candidate, level / FAMILIES))
    }

    /// The pool with all but the base model's columns projected out, and where its columns begin.
    pub fn screen(&mut self, fitter: &Fitter<'_, '_>, fit: &Fit) -> Result<(Screen, usize), Error> {
        let kept = self.white.take().filter(|(noise, _)| noise.same(fitter.noise));
        let white = match kept {
            Some((_, white)) => white,
            None => fitter.noise.whiten_all(&fitter.model.observed, &self.pool.columns),
        };
        let base = fit.jacobian.ncols();
        let first: Vec<usize> = (0..base).collect();
        let screen = Screen::of(&fitter.products(&fit.jacobian, &white, &fit.white)).given(&first)?;
        self.white = Some((fitter.noise.clone(), white));
        Ok((screen, base))
    }

    /// Searches what a fit has left.
    pub fn look(&mut self, fitter: &Fitter<'_, '_>, fit: &Fit) -> Result<Look, Error> {
        let (screen, base) = self.screen(fitter, fit)?;
        let searches: Vec<Search> = self
            .pool
            .candidates
            .iter()
            .map(|candidate| {
                let group =
                    |trial: &crate::candidates::Trial| trial.columns.iter().map(|c| base + c).collect();
                candidate.trials.iter().map(group).collect()
            })
            .collect();
        if self.chance.is_none() {
            let mut stream = Stream::new(self.seed, "diagnose/chance");
            let normals = Mat::from_fn(DRAWS, self.pool.columns.len(), |_, _| stream.normal());
            self.chance = Some(Chance::of(&screen, &searches, &normals)?);
        }
        let rest = Rest {
            sum_of_squares: screen.sum_of_squares(),
            freedom: screen.freedom(),
            known: fitter.noise.known,
        };
        let families = |p: f64| at_least_one(p, FAMILIES);
        let mut proposals = Vec::new();
        let mut structures: Vec<Structure> = Vec::new();
        let mut least_p = 1.0_f64;
        for (number, (candidate, search)) in self.pool.candidates.iter().zip(&searches).enumerate() {
            if already(&fit.state, candidate) {
                continue;
            }
            let mut best: Option<(f64, f64, usize, Vec<f64>, usize)> = None;
            let mut sizes = Vec::new();
            for (at, group) in search.iter().enumerate() {
                let gain = screen.gain(group)?;
                let p = rest.p(gain.gain, gain.rank);
                sizes.push((gain.gain, gain.coefficients.first().copied().unwrap_or(0.0)));
                if best
                    .as_ref()
                    .is_none_or(|(least, most, ..)| p < *least || (p == *least && gain.gain > *most))
                {
                    best = Some((p, gain.gain, at, gain.coefficients, gain.rank));
                }
            }
            let Some((p, gain, at, coefficients, rank)) = best else { continue };
            let chance =
                self.chance.as_ref().map_or(1.0, |chance| chance.adjusted(chance.searched(number, p)));
            least_p = least_p.min(families(chance));
            if families(chance) >= self.level {
                continue;
            }
            match &candidate.what {
                What::Smooth { .. } => {
                    let (what, p_adjusted) = (candidate.what.clone(), families(chance));
                    structures.push(Structure { what, p_adjusted, gain, unknowns: rank as f64 });
                }
                _ => {
                    if let Some(addition) = start(candidate, self.pool, at, &coefficients, &sizes) {
                        let name = candidate.what.name();
                        proposals.push(Proposal {
                            name,
                            addition,
                            p: chance,
                            gain,
                            searched: 0.0,
                            local: false,
                        });
                    }
                }
            }
        }
        let (line, of_lines) = lines::proposals(fitter, fit, &rest);
        let others = of_lines
            .into_iter()
            .chain(events::proposals(fitter, fit, &rest)?)
            .chain(codes::proposals(fitter, fit, &rest)?);
        for other in others {
            least_p = least_p.min(families(other.p));
            if families(other.p) < self.level {
                proposals.push(other);
            }
        }
        least_p = least_p.min(line.as_ref().map_or(1.0, |line| families(line.p)));
        let size = |p: &Proposal| -> f64 {
            let unknowns = match &p.addition {
                Addition::Effect(effect) => effect.parameters.len() as f64,
                Addition::Column(_) => 1.0,
            };
            p.gain - (unknowns + p.searched) * (fit.white.len() as f64).ln()
        };
        proposals.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let worth = |s: &Structure| s.gain - s.unknowns * (fit.white.len() as f64).ln();
        structures.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        Ok(Look { rest, proposals, structures, line, least_p })
    }

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
            let Ok(with) = fitter.refine(&state) else { return Ok(None) };
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
            let why_not = self.why_not(proposal, fit, &with, &held_out, look);
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
        let refined: Vec<Option<Refined>> = promising.par_iter().map(one).collect::<Result<_, Error>>()?;
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
        if let Addition::Effect(effect) = &proposal.addition {
            let found = with.state.effects.last()?;
            for (info, value) in effect.kind.parameters().iter().zip(&found.parameters) {
                let beyond = match info.role {
                    Role::Amplitude => value.abs() > BEYOND * info.high,
                    Role::Shape => *value > BEYOND * info.high || *value < info.low / BEYOND,
                    Role::Epoch => false,
                };
                if beyond {
                    let words = format!("{} would have to be {value:.3e}, which is not plausible", info.name);
                    let amplitude = info.role == Role::Amplitude;
                    return Some(if amplitude { Fault::Implausible(words) } else { Fault::Idle(words) });
                }
            }
            let candidate = self
                .pool
                .candidates
                .iter()
                .find(|c| matches!(&c.what, What::Physics(e) if named(e) == named(found)));
            let shape = found.kind.parameters().iter().position(|info| info.role == Role::Shape);
            if let (Some(candidate), Some(at)) = (candidate.filter(|c| !c.finite), shape) {
                let tried: Vec<f64> = candidate.trials.iter().filter_map(|trial| trial.shape).collect();
                let (low, high) =
                    tried.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), s| (l.min(*s), h.max(*s)));
                let name = found.kind.parameters()[at].name;
                if found.parameters[at] < 0.9 * low {
                    return idle(format!("{name} runs to nothing, where a simpler effect says the same"));
                }
                if found.parameters[at] > 1.1 * high {
                    return idle(format!(
                        "{name} runs beyond what the recording spans, where a simpler effect says the same"
                    ));
                }
            }
        }
        let total: f64 = held_out.iter().sum();
        if !proposal.local && total <= 0.0 {
            return idle("it does not predict readings that were left out".into());
        }
        None
    }
}

/// Whether a state holds a candidate's effect already.
fn already(state: &State, candidate: &Candidate) -> bool {
    match &candidate.what {
        What::Physics(effect) => state.effects.iter().any(|other| named(other) == named(effect)),
        What::Dependence { .. } => state.columns.iter().any(|column| column.what == candidate.what.name()),
        What::Smooth { .. } => false,
    }
}

/// Where the refinement of a candidate begins.
fn start(
    candidate: &Candidate,
    pool: &Pool,
    best: usize,
    coefficients: &[f64],
    sizes: &[(f64, f64)],
) -> Option<Addition> {
    match &candidate.what {
        What::Physics(template) => {
            let mut effect = template.clone();
            let infos = effect.kind.parameters();
            let shape = infos.iter().position(|info| info.role == Role::Shape);
            if candidate.finite {
                // What an effect without amplitude does at a shape must be what is seen: the coefficient is one.
                let most = sizes.iter().map(|(gain, _)| *gain).fold(0.0, f64::max);
                let near = |at: &usize| sizes[*at].1.ln().abs();
                let fitting = (0..sizes.len()).filter(|at| sizes[*at].1 > 0.0 && sizes[*at].0 > 0.5 * most);
                let at = fitting.min_by(|a, b| near(a).total_cmp(&near(b)))?;
                effect.parameters[shape?] = candidate.trials[at].shape?;
                return Some(Addition::Effect(effect));
            }
            let mut amplitudes = coefficients.iter();
            for (k, info) in infos.iter().enumerate() {
                match info.role {
                    Role::Amplitude => effect.parameters[k] = *amplitudes.next()?,
                    _ => effect.parameters[k] = candidate.trials[best].shape?,
                }
            }
            Some(Addition::Effect(effect))
        }
        what => {
            let column = candidate.trials[best].columns.first()?;
            let values = Arc::new(pool.columns[*column].clone());
            let follows = match what {
                What::Dependence { column, axis } => Some(Follows {
                    column: column.clone(),
                    axis: *axis,
                    lag_s: candidate.trials[best].shape.unwrap_or(0.0),
                    lag_std_s: None,
                }),
                _ => None,
            };
            let coefficient = *coefficients.first()?;
            Some(Addition::Column(Column { what: what.name(), follows, values, coefficient }))
        }
    }
}
