//! Which causes together explain the readings best.

use std::collections::BTreeMap;

use crate::form::Form;
use crate::problem::Cause;
use crate::stack::{Candidate, Named, Product, Stack};
use crate::sweep::{Sweep, sum};

/// ln of the odds against a cause before the readings are looked at, beside those of its being one of so many.
const AGAINST: f64 = 3.0;
/// Sets that are carried on from one size to the next, and the most causes of a set.
const BEAM: usize = 6;
const MOST: usize = 12;

#[derive(Clone, Debug)]
pub struct Set {
    pub named: Vec<Named>,
    /// ln of prior times evidence.
    pub evidence: f64,
}

/// A set of causes, in whichever forms, with its probability.
#[derive(Clone, Debug)]
pub struct Rival {
    /// The causes.
    pub causes: Vec<Cause>,
    /// ln of prior times evidence.
    pub evidence: f64,
    /// Its probability among all that were weighed.
    pub probability: f64,
}

/// The causes that were thought of, each with the number of its forms.
pub type Thought = BTreeMap<Cause, usize>;

/// ln of the prior share of a form among those of its cause: half of it is that the cause acts at once.
fn of_form(candidate: &Candidate, forms: usize) -> f64 {
    match forms {
        0 | 1 => 0.0,
        _ if candidate.form == Form::default() => -std::f64::consts::LN_2,
        others => -(2.0 * (others as f64 - 1.0)).ln(),
    }
}

/// ln of the odds for a cause of so many unknowns in each channel, from the square of these over their uncertainties: shown
/// in the channels where that pays, with so many rows and so many causes that are weighed.
pub fn odds(squares: &[f64], unknowns: usize, rows: usize, causes: usize) -> f64 {
    let net = |square: &f64| 0.5 * (square - unknowns as f64 * (rows as f64).ln_1p());
    let best = squares.iter().map(net).fold(f64::NEG_INFINITY, f64::max);
    let others: f64 = squares.iter().map(net).filter(|net| *net > 0.0).sum();
    best.min(0.0) + others - AGAINST - (causes.max(1) as f64).ln()
}

/// The search over sets of candidates.
pub struct Search<'a> {
    stack: &'a Stack,
    base: &'a [usize],
    products: Vec<&'a [Product]>,
    /// ln of the prior odds of each candidate.
    prior: Vec<f64>,
    without: Vec<Cause>,
    weighed: BTreeMap<Vec<Cause>, f64>,
}

impl<'a> Search<'a> {
    /// Over the candidates of a stack, with their products.
    pub fn new(stack: &'a Stack, products: &'a [Product], thought: &Thought) -> Self {
        Self::of_channels((stack, &stack.base), vec![products; stack.y.len()], thought)
    }

    /// The same with another base, and with products of its own for each channel.
    pub fn of_channels(
        (stack, base): (&'a Stack, &'a [usize]),
        products: Vec<&'a [Product]>,
        thought: &Thought,
    ) -> Self {
        let of = |candidate: &Candidate| {
            let forms = thought.get(&candidate.cause).copied().unwrap_or(1);
            -AGAINST - (thought.len().max(1) as f64).ln() + of_form(candidate, forms) - candidate.looks
        };
        let prior = stack.candidates.iter().map(of).collect();
        Self { stack, base, products, prior, without: Vec::new(), weighed: BTreeMap::new() }
    }

    /// The same where some causes do not act.
    pub fn without(self, causes: &[Cause]) -> Self {
        Self { without: causes.to_vec(), ..self }
    }

    /// The best set, and all that were weighed with their probabilities, the most probable first.
    pub fn best(mut self) -> (Set, Vec<Rival>) {
        let nothing = Set { named: Vec::new(), evidence: self.evidence(&[]) };
        self.weighed.insert(Vec::new(), nothing.evidence);
        let (mut beam, mut best) = (vec![nothing.clone()], nothing);
        for _ in 0..MOST {
            let mut next: Vec<Set> = beam.iter().flat_map(|set| self.larger(set)).collect();
            next.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
            next.dedup_by(|a, b| self.causes(a) == self.causes(b));
            next.truncate(BEAM);
            let Some(first) = next.first() else { break };
            if first.evidence <= best.evidence {
                break;
            }
            best = self.exchanged(first.clone());
            next[0] = best.clone();
            beam = next;
        }
        (best, self.rivals())
    }

    /// ln of prior times evidence of some candidates together.
    pub fn evidence(&self, named: &[Named]) -> f64 {
        let sweeps = self.sweeps(named);
        let costs: f64 = named.iter().map(|one| self.cost(one, sweeps[0].width())).sum();
        sweeps.iter().map(Sweep::evidence).sum::<f64>() - costs
    }

    /// The probability of each form of noise in each channel beside some candidates.
    pub fn noise_weights(&self, named: &[Named]) -> Vec<Vec<f64>> {
        self.sweeps(named).iter().map(Sweep::weights).collect()
    }

    fn cost(&self, named: &Named, width: f64) -> f64 {
        let candidate = &self.stack.candidates[named.candidate];
        let own = |(columns, shows): (&Vec<usize>, &bool)| if *shows { columns.len() } else { 0 };
        let each = candidate.columns.iter().zip(&named.channels).map(own);
        let unknowns = if candidate.tied { each.max().unwrap_or(0) } else { each.sum() };
        unknowns as f64 * width + self.patterns(candidate) - self.prior[named.candidate]
    }

    /// ln of the number of ways to choose the channels on which a candidate shows.
    fn patterns(&self, candidate: &Candidate) -> f64 {
        if candidate.tied { 0.0 } else { (2f64.powi(candidate.columns.len() as i32) - 1.0).ln() }
    }

    fn sweeps(&self, named: &[Named]) -> Vec<Sweep<'a>> {
        let of = |channel: usize| {
            let columns = self.stack.shown(named, channel);
            Sweep::of(self.products[channel], self.stack, channel, self.base, &columns)
        };
        (0..self.stack.y.len()).map(of).collect()
    }

    fn causes(&self, set: &Set) -> Vec<Cause> {
        let mut causes: Vec<Cause> =
            set.named.iter().map(|one| self.stack.candidates[one.candidate].cause).collect();
        causes.sort();
        causes
    }

    /// The sets with one cause more, each in its best form.
    fn larger(&mut self, set: &Set) -> Vec<Set> {
        let mut of_cause: BTreeMap<Cause, (Set, Vec<f64>)> = BTreeMap::new();
        for (named, gain) in self.offers(&set.named) {
            let cause = self.stack.candidates[named.candidate].cause;
            let evidence = set.evidence + gain;
            let larger = || {
                let named = set.named.iter().cloned().chain([named.clone()]).collect();
                Set { named, evidence }
            };
            let (best, all) = of_cause.entry(cause).or_insert_with(|| (larger(), Vec::new()));
            if evidence > best.evidence {
                *best = larger();
            }
            all.push(evidence);
        }
        for (larger, all) in of_cause.values() {
            self.weigh(larger, sum(all.iter().copied()));
        }
        of_cause.into_values().map(|(larger, _)| larger).collect()
    }

    fn weigh(&mut self, set: &Set, evidence: f64) {
        let known = self.weighed.entry(self.causes(set)).or_insert(evidence);
        *known = known.max(evidence);
    }

    /// Each candidate of a cause that is not in a set, with the channels on which it shows and what it adds to
    /// ln of the evidence.
    pub fn offers(&self, named: &[Named]) -> Vec<(Named, f64)> {
        let sweeps = self.sweeps(named);
        let before: Vec<f64> = sweeps.iter().map(Sweep::evidence).collect();
        let known = named.iter().map(|one| self.stack.candidates[one.candidate].cause);
        let taken: Vec<Cause> = known.chain(self.without.iter().copied()).collect();
        let width = sweeps[0].width();
        let mut offers = Vec::new();
        for (number, candidate) in self.stack.candidates.iter().enumerate() {
            if taken.contains(&candidate.cause) {
                continue;
            }
            let of = |((sweep, before), columns): ((&Sweep<'_>, &f64), &Vec<usize>)| {
                let (evidence, rank) = sweep.with(columns);
                (evidence - before, rank as f64 * width)
            };
            let gains: Vec<(f64, f64)> = sweeps.iter().zip(&before).zip(&candidate.columns).map(of).collect();
            let own = self.prior[number] - self.patterns(candidate);
            if candidate.tied {
                let unknowns = gains.iter().map(|(_, width)| *width).fold(0.0, f64::max);
                let gain = gains.iter().map(|(gain, _)| gain).sum::<f64>() - unknowns + own;
                offers.push((Named { candidate: number, channels: vec![true; gains.len()] }, gain));
                continue;
            }
            let net: Vec<f64> = gains.iter().map(|(gain, width)| gain - width).collect();
            let largest = net.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let channels: Vec<bool> = net.iter().map(|net| *net > 0.0 || *net == largest).collect();
            let gain: f64 = net.iter().zip(&channels).filter(|(_, shows)| **shows).map(|(net, _)| net).sum();
            offers.push((Named { candidate: number, channels }, gain + own));
        }
        offers
    }

    /// The set after each of its causes was taken out and the best put in its place, until none is better.
    fn exchanged(&mut self, mut set: Set) -> Set {
        for _ in 0..MOST {
            let better = (0..set.named.len()).find_map(|out| {
                let mut rest = set.named.clone();
                rest.remove(out);
                let smaller = Set { evidence: self.evidence(&rest), named: rest };
                self.weigh(&smaller, smaller.evidence);
                let all = self.larger(&smaller).into_iter().chain([smaller]);
                let best = all.max_by(|a, b| a.evidence.total_cmp(&b.evidence));
                best.filter(|best| best.evidence > set.evidence + 1e-6)
            });
            let Some(better) = better else { break };
            set = better;
        }
        set
    }

    fn rivals(&self) -> Vec<Rival> {
        let total = sum(self.weighed.values().copied());
        let of = |(causes, evidence): (&Vec<Cause>, &f64)| Rival {
            causes: causes.clone(),
            evidence: *evidence,
            probability: (evidence - total).exp(),
        };
        let mut rivals: Vec<Rival> = self.weighed.iter().map(of).collect();
        rivals.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        rivals
    }
}
