//! A look at what a fit has left: which candidates stand out of it, and how probable that is by chance.

use common::{Axis, Detectable};
use estimate::screen::{Chance, Screen, Search};
use noise::Stream;
use physics::EffectInstance;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::candidates::Candidate;
use crate::codes;
use crate::events;
use crate::fit::{Fit, Fitter};
use crate::level::{Rest, at_least_one};
use crate::lines::{self, Line};
use crate::model::named;
use crate::model::{Model, State};
use crate::pool::Pool;
use crate::products::Products;
use crate::projection::Projection;
use crate::proposal::What;
use crate::proposal::{Addition, Proposal};
use crate::whitening::NoiseModel;
use crate::{Error, Ground, Options};

/// So many candidates of each look are kept, those that are worth most.
const STRIKING: usize = 12;

/// Families of candidates that are searched apart: grids, lines, events, codes, the size of what is left.
const FAMILIES: f64 = 5.0;

#[derive(Clone, Debug)]
pub struct Structure {
    /// What the sensor follows.
    pub covariate: String,
    pub axis: Axis,
    /// The shape at which it does so best.
    pub shape: Option<f64>,
    /// Probability by chance, all families.
    pub p_adjusted: f64,
    pub gain: f64,
    pub unknowns: f64,
}

impl Structure {
    pub fn name(&self) -> String {
        What::Smooth { covariate: self.covariate.clone(), axis: self.axis }.name()
    }
}

#[derive(Clone, Debug)]
pub struct Striking {
    pub name: String,
    /// Probability by chance within its family, the search included.
    pub p: f64,
    /// By how much it lowers the sum of squares, less ln n for each of its unknowns.
    worth: f64,
}

#[derive(Clone, Debug)]
pub struct Look {
    /// What is left before anything comes in.
    pub rest: Rest,
    /// Names below the level, those that are worth most first.
    pub names: Vec<Striking>,
    /// Those of them that were found at moments, frequencies or in codes.
    pub events: Vec<Proposal>,
    /// What follows smooth functions of something, the most striking first.
    pub structures: Vec<Structure>,
    pub line: Option<Line>,
    /// Smallest probability of all, families counted.
    pub least_p: f64,
}

impl Look {
    /// Whether the sum of squares is beyond what the noise makes, as well as its size is known.
    pub fn exceeds(&self, level: f64) -> bool {
        self.rest.omnibus().is_some_and(|p| at_least_one(p, FAMILIES) < level)
    }

    /// Whether nothing is left but the noise.
    pub fn clean(&self, level: f64) -> bool {
        self.least_p >= level && !self.exceeds(level)
    }
}

pub struct Searcher<'m, 'a> {
    pub model: &'m Model<'a>,
    /// Hears what is being done.
    pub told: &'m dyn Fn(&str),
    pub pool: Arc<Pool>,
    /// The products of the pool's columns, and the noise that whitened them.
    white: Option<(NoiseModel, Products)>,
    /// How great gains are by chance.
    pub chance: Option<Chance>,
    seed: u64,
    /// Probability of a false alarm.
    pub level: f64,
    /// Candidates of all sets that were weighed, and what stood out, each with its shapes.
    pub kept: BTreeMap<usize, BTreeSet<usize>>,
    pub shapes: Vec<EffectInstance>,
    /// What all could have shown, where a search on some of the rows went before.
    pub detectable: Option<Vec<Detectable>>,
}

impl<'m, 'a> Searcher<'m, 'a> {
    pub fn new(model: &'m Model<'a>, pool: Pool, options: &Options, told: &'m dyn Fn(&str)) -> Self {
        Self {
            model,
            told,
            pool: pool.into(),
            white: None,
            chance: None,
            seed: options.seed,
            level: options.level,
            kept: BTreeMap::new(),
            shapes: Vec::new(),
            detectable: None,
        }
    }

    /// Whether a search on some of the rows went before: it has shown shapes.
    pub fn is_second(&self) -> bool {
        self.detectable.is_some()
    }

    /// Keeps candidates, each with the number of a shape.
    pub fn keep(&mut self, of: impl Iterator<Item = (usize, usize)>) {
        of.for_each(|(number, shape)| {
            self.kept.entry(number).or_default().insert(shape);
        });
    }

    /// The probability of one shape of a candidate at which it is claimed.
    pub fn threshold(&self, candidate: usize) -> f64 {
        let of = |chance: &Chance| chance.threshold(candidate, self.level / FAMILIES);
        self.chance.as_ref().map_or(self.level, of)
    }

    pub fn products(&mut self, fitter: &Fitter<'_, '_>) -> &Products {
        let noise = fitter.noise;
        let kept = self.white.take().filter(|(known, _)| noise.same(known));
        let found = kept.unwrap_or_else(|| {
            let mut products = Products::of(&fitter.model.observed);
            products.push_groups(noise, &self.pool.columns, &self.pool.groups());
            (noise.clone(), products)
        });
        &self.white.insert(found).1
    }

    /// The pool with all that a fit has unknown projected out, and the way there.
    pub fn screen(&mut self, fitter: &Fitter<'_, '_>, fit: &Fit) -> Result<(Projection, Screen), Error> {
        let mut projection = Projection::of(fit)?;
        let mut screen = projection.screen();
        projection.extend(&mut screen, self.products(fitter));
        Ok((projection, screen))
    }

    /// The strongest line, and what may have happened at moments, at frequencies or in codes.
    pub fn events(
        &self,
        fitter: &Fitter<'_, '_>,
        fit: &Fit,
        rest: &Rest,
    ) -> Result<(Option<Line>, Vec<Proposal>), Error> {
        let (line, mut found) = lines::proposals(fitter, fit, rest);
        found.extend(self.moments(fitter, fit, rest)?);
        found.extend(codes::proposals(fitter, fit, rest)?);
        found.retain(|proposal| self.counts(proposal));
        Ok((line, found))
    }

    pub fn moments(&self, fitter: &Fitter<'_, '_>, fit: &Fit, rest: &Rest) -> Result<Vec<Proposal>, Error> {
        let mut found = events::proposals(fitter, fit, rest)?;
        found.retain(|proposal| self.counts(proposal));
        Ok(found)
    }

    /// Whether something that was found by itself is considered and stands out.
    fn counts(&self, proposal: &Proposal) -> bool {
        self.pool.considers(proposal) && at_least_one(proposal.p, FAMILIES) < self.level
    }

    /// A fit with what stands out of it.
    pub fn ground(&mut self, fit: Fit, noise: NoiseModel) -> Result<Ground, Error> {
        let look = self.look(&Fitter { model: self.model, noise: &noise }, &fit)?;
        Ok(Ground { fit, noise, look, codes: Vec::new() })
    }

    /// Searches what a fit has left.
    fn look(&mut self, fitter: &Fitter<'_, '_>, fit: &Fit) -> Result<Look, Error> {
        let (projection, screen) = self.screen(fitter, fit)?;
        let of = |candidate: &Candidate| candidate.shapes.iter().map(|shape| shape.columns.clone()).collect();
        let searches: Vec<Search> = self.pool.candidates.iter().map(of).collect();
        if self.chance.is_none() {
            let mut stream = Stream::new(self.seed, "diagnose/chance");
            let draws = projection.draws(self.products(fitter), &mut stream);
            self.chance = Some(Chance::of(&screen, &searches, &draws)?);
        }
        let rest = Rest {
            sum_of_squares: screen.sum_of_squares(),
            freedom: screen.freedom(),
            known: fitter.noise.known,
        };
        let families = |p: f64| at_least_one(p, FAMILIES);
        let mut names = Vec::new();
        let log_rows = (fit.white.len() as f64).ln();
        let mut structures: Vec<Structure> = Vec::new();
        let mut striking: Vec<(f64, usize, usize)> = Vec::new();
        let mut least_p = 1.0_f64;
        for (number, (candidate, search)) in self.pool.candidates.iter().zip(&searches).enumerate() {
            if already(&fit.state, candidate) {
                continue;
            }
            let mut best: Option<(f64, f64, usize, usize)> = None;
            let mut sizes = Vec::new();
            for (trial, group) in search.iter().enumerate() {
                let gain = screen.gain(group)?;
                let p = rest.p(gain.gain, gain.rank);
                sizes.push((gain.gain, gain.coefficients.first().copied().unwrap_or(0.0)));
                if best
                    .as_ref()
                    .is_none_or(|(least, most, ..)| p < *least || (p == *least && gain.gain > *most))
                {
                    best = Some((p, gain.gain, gain.rank, trial));
                }
            }
            let Some((p, gain, rank, trial)) = best else { continue };
            let shape = candidate.shapes[trial].value;
            let chance =
                self.chance.as_ref().map_or(1.0, |chance| chance.adjusted(chance.searched(number, p)));
            striking.push((gain - rank as f64 * log_rows, number, trial));
            least_p = least_p.min(families(chance));
            if families(chance) >= self.level {
                continue;
            }
            match &candidate.what {
                What::Smooth { covariate, axis } => {
                    let (covariate, p_adjusted, unknowns) =
                        (covariate.clone(), families(chance), rank as f64);
                    structures.push(Structure { covariate, axis: *axis, shape, p_adjusted, gain, unknowns });
                }
                What::Event(_) => {}
                What::Physics(effect) => {
                    // What an effect without amplitude does at a shape must be what is seen, and not its
                    // opposite.
                    let most = sizes.iter().map(|(gain, _)| *gain).fold(0.0, f64::max);
                    let seen = |(gain, size): &(f64, f64)| *size > 0.0 && *gain > 0.5 * most;
                    if !candidate.finite || sizes.iter().any(seen) {
                        let worth = gain - effect.parameters.len() as f64 * log_rows;
                        names.push(Striking { name: candidate.what.name(), p: chance, worth });
                    }
                }
            }
        }
        striking.sort_by(|a, b| b.0.total_cmp(&a.0));
        striking.truncate(STRIKING);
        self.keep(striking.into_iter().map(|(_, number, trial)| (number, trial)));
        let (line, events) = self.events(fitter, fit, &rest)?;
        for event in &events {
            least_p = least_p.min(families(event.p));
            let unknowns = match &event.addition {
                Addition::Effect(effect) => effect.parameters.len() as f64,
                Addition::Single(_) => 1.0,
            };
            names.push(Striking {
                name: event.name.clone(),
                p: event.p,
                worth: event.gain - unknowns * log_rows,
            });
        }
        least_p = least_p.min(line.as_ref().map_or(1.0, |line| families(line.p)));
        names.sort_by(|a, b| b.worth.total_cmp(&a.worth));
        let worth = |s: &Structure| s.gain - s.unknowns * log_rows;
        structures.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
        Ok(Look { rest, names, events, structures, line, least_p })
    }
}

fn already(state: &State, candidate: &Candidate) -> bool {
    match &candidate.what {
        What::Physics(effect) => state.effects.iter().any(|other| named(other) == named(effect)),
        _ => false,
    }
}
