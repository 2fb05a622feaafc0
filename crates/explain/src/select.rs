//! From all causes in all forms to the best set: screened on some of the rows, decided on all of them.

use estimate::Error;
use rayon::prelude::*;

use crate::amplitude::{self, Amplitude};
use crate::fit::Fit;
use crate::form::Form;
use crate::noises::{self, Filter};
use crate::problem::{Cause, Problem};
use crate::reference::{SHARES, held};
use crate::search::{Rival, Search, Thought};
use crate::stack::{Named, Product, Stack, product, products};
use crate::sweep::Sweep;

/// Up to so many rows all forms are weighed on all rows; beyond, they are screened on so many in so many blocks.
const ROWS: usize = 8_192;
const BLOCKS: usize = 16;
/// Forms of a cause that are weighed on all rows.
const FORMS: usize = 5;
/// Most columns that are screened at once.
const AT_ONCE: usize = 160;
/// Forms are screened under every so many of the laws of noise.
const LAWS_APART: usize = 3;
/// Rounds of a set and of the noise of what it leaves.
const ROUNDS: usize = 3;
/// Rounds of a spectrum and of the fit under it.
const SPECTRA: usize = 3;
/// A law of noise that is less probable on so many rows is none on all.
const IMPROBABLE: f64 = 1e-15;
/// A refined relaxation is between those of the grid by these factors.
const NEARER: [f64; 2] = [1.2, 1.06];

/// The best set of causes, and how likely it is.
pub struct Selected {
    pub named: Vec<(Cause, Form)>,
    /// ln of the odds of the set with and without each of them.
    pub gains: Vec<f64>,
    pub rivals: Vec<Rival>,
    /// The forms that were weighed on all rows.
    pub offered: Vec<(Cause, Form)>,
    pub noises: Vec<Filter>,
}

/// Causes in their forms on all channels: ln of the odds for all of them together, and their amplitudes.
///
/// Errors: times out of order.
pub fn weigh(problem: &Problem, offered: &[(Cause, Form)]) -> Result<(f64, Vec<Amplitude>), Error> {
    let laws = Filter::all(noises::laws(problem.step_s()), &problem.time_s)?;
    let stack = Stack::of(problem, offered);
    let made = products(&stack, &laws);
    let named = |candidate: usize| Named { candidate, channels: vec![true; problem.channels.len()] };
    let set: Vec<Named> = (0..offered.len()).map(named).collect();
    let (noises, _) = with_spectra(problem, &stack, &laws, &made, &set)?;
    let gain = gains(problem, offered, &set, &noises, &Thought::new(), &[(0..offered.len()).collect()])[0];
    Ok((gain, amplitude::fit(problem, offered, &noises).amplitudes))
}

/// All causes of a problem in the forms that are weighed on all rows, with their products under the laws of noise that
/// remain plausible.
pub struct Screened<'a> {
    problem: &'a Problem,
    thought: Thought,
    offered: Vec<(Cause, Form)>,
    laws: usize,
    stack: Stack,
    /// The laws, then the spectra of what is left where nothing acts; with their products.
    noises: Vec<Filter>,
    products: Vec<Product>,
}

impl<'a> Screened<'a> {
    /// Of a problem.
    pub fn of(problem: &'a Problem) -> Result<Self, Error> {
        let forms = |cause: Cause| Form::all(problem, cause).into_iter().map(move |form| (cause, form));
        let mut offered: Vec<(Cause, Form)> = problem.causes().into_iter().flat_map(forms).collect();
        let mut thought = Thought::new();
        offered.iter().for_each(|(cause, _)| *thought.entry(*cause).or_default() += 1);
        let mut laws = noises::laws(problem.step_s());
        if problem.rows() > ROWS || offered.len() > AT_ONCE {
            let thin = problem.at(&thinned(problem.rows(), ROWS, BLOCKS));
            let filters = Filter::all(laws, &thin.time_s)?;
            let some: Vec<Filter> = filters.iter().step_by(LAWS_APART).cloned().collect();
            offered = screened(&thin, &offered, &some, &thought);
            laws = probable(&thin, &offered, filters, &thought);
        }
        let stack = Stack::of(problem, &offered);
        let filters = Filter::all(laws, &problem.time_s)?;
        let made = products(&stack, &filters);
        let (noises, products) = with_spectra(problem, &stack, &filters, &made, &[])?;
        Ok(Self { problem, thought, offered, laws: filters.len(), stack, noises, products })
    }

    /// The best set of all causes but some; what noise of the reference may imitate is no name.
    pub fn select(&self, without: &[Cause]) -> Result<Selected, Error> {
        let mut without = without.to_vec();
        loop {
            let selected = self.best(&without)?;
            let weakest =
                (0..selected.gains.len()).min_by(|a, b| selected.gains[*a].total_cmp(&selected.gains[*b]));
            match weakest.filter(|weakest| selected.gains[*weakest] <= 0.0) {
                None => return Ok(selected),
                Some(weakest) => without.push(selected.named[weakest].0),
            }
        }
    }

    fn best(&self, without: &[Cause]) -> Result<Selected, Error> {
        let Self { problem, stack, thought, .. } = self;
        let best = |made: &[Product]| Search::new(stack, made, thought).without(without).best();
        let mut noises = self.noises.clone();
        let (mut set, mut rivals) = best(&self.products);
        // The noise is what the right set leaves.
        for _ in 1..ROUNDS {
            if set.named.is_empty() {
                break;
            }
            let (laws, made) = (&self.noises[..self.laws], &self.products[..self.laws]);
            let (filters, made) = with_spectra(problem, stack, laws, made, &set.named)?;
            noises = filters;
            let before = set;
            (set, rivals) = best(&made);
            if set.named == before.named {
                break;
            }
        }
        if set.named.is_empty() {
            noises = self.noises.clone();
        }
        let candidates = set.named.iter().map(|one| &stack.candidates[one.candidate]);
        let mut named: Vec<(Cause, Form)> = candidates.map(|one| (one.cause, one.form)).collect();
        // Numbered as in a stack of the named ones alone.
        let of = |(candidate, one): (usize, &Named)| Named { candidate, ..one.clone() };
        let set: Vec<Named> = set.named.iter().enumerate().map(of).collect();
        for by in NEARER {
            refine(problem, &mut named, &set, &noises, by);
        }
        let each: Vec<Vec<usize>> = (0..named.len()).map(|one| vec![one]).collect();
        let gains = gains(problem, &named, &set, &noises, thought, &each);
        Ok(Selected { named, gains, rivals, offered: self.offered.clone(), noises })
    }
}

/// Laws of noise, and for each channel the spectrum of what the most probable of all leaves beside a set: fitted
/// again under that noise, for under another the field's coefficients are others.
fn with_spectra(
    problem: &Problem,
    stack: &Stack,
    laws: &[Filter],
    of_laws: &[Product],
    set: &[Named],
) -> Result<(Vec<Filter>, Vec<Product>), Error> {
    let (mut forms, mut made) = (laws.to_vec(), of_laws.to_vec());
    for round in 0..SPECTRA {
        let fitted = (0..stack.y.len()).filter_map(|channel| {
            let (y, own) = (stack.y[channel], stack.shown(set, channel));
            let best = Sweep::of(&made, stack, channel, &stack.base, &own).best();
            let fit = Fit::of(&made[best].gram, y, &[&stack.base[..], &own].concat());
            noises::fitted(&fit.rest(&stack.columns, &stack.columns[y]), problem.step_s())
        });
        let fitted = Filter::all(fitted.collect(), &problem.time_s)?;
        forms.truncate(laws.len());
        made.truncate(laws.len());
        // Until the last the set's own columns are enough.
        made.extend(if round + 1 == SPECTRA {
            products(stack, &fitted)
        } else {
            let all = (0..stack.y.len()).flat_map(|channel| stack.shown(set, channel));
            let mut among: Vec<usize> = stack.base.iter().chain(&stack.y).copied().chain(all).collect();
            among.sort_unstable();
            among.dedup();
            fitted.par_iter().map(|filter| product(stack, &among, filter)).collect()
        });
        forms.extend(fitted);
    }
    Ok((forms, made))
}

/// At most so many rows, in so many blocks that are spread over all.
pub fn thinned(rows: usize, most: usize, blocks: usize) -> Vec<usize> {
    let each = most / blocks;
    if rows <= most {
        return (0..rows).collect();
    }
    let from = |block: usize| block * (rows - each) / (blocks - 1);
    (0..blocks).flat_map(|block| from(block)..from(block) + each).collect()
}

/// White noise, and the other laws that are plausible on some of the rows, where nothing acts or beside the best set.
fn probable(
    thin: &Problem,
    offered: &[(Cause, Form)],
    laws: Vec<Filter>,
    thought: &Thought,
) -> Vec<noises::Form> {
    let stack = Stack::of(thin, offered);
    let made = products(&stack, &laws);
    let search = || Search::new(&stack, &made, thought);
    let (best, _) = search().best();
    let weights: Vec<Vec<f64>> =
        [&[][..], &best.named].iter().flat_map(|set| search().noise_weights(set)).collect();
    let is_probable =
        |(number, _): &(usize, Filter)| *number == 0 || weights.iter().any(|own| own[*number] > IMPROBABLE);
    laws.into_iter().enumerate().filter(is_probable).map(|(_, law)| law.form).collect()
}

/// The forms of each cause that explain most by themselves and beside the best set.
fn screened(
    thin: &Problem,
    offered: &[(Cause, Form)],
    noises: &[Filter],
    thought: &Thought,
) -> Vec<(Cause, Form)> {
    let mut kept: Vec<(Cause, Form)> = Vec::new();
    let mut rest = offered;
    while !rest.is_empty() {
        // Whole causes, so many at a time.
        let mut many = rest.len().min(AT_ONCE);
        while many < rest.len() && rest[many].0 == rest[many - 1].0 {
            many += 1;
        }
        let (group, later) = rest.split_at(many);
        rest = later;
        kept.extend(best_forms(thin, group, noises, thought));
    }
    kept
}

fn best_forms(
    thin: &Problem,
    group: &[(Cause, Form)],
    noises: &[Filter],
    thought: &Thought,
) -> Vec<(Cause, Form)> {
    let stack = Stack::of(thin, group);
    let made = products(&stack, noises);
    let search = || Search::new(&stack, &made, thought);
    let (best, _) = search().best();
    let mut kept: Vec<(Cause, Form)> = Vec::new();
    let mut keep = |one: (Cause, Form)| {
        if !kept.contains(&one) {
            kept.push(one);
        }
    };
    best.named.iter().for_each(|named| keep(group[named.candidate]));
    for set in [&[][..], &best.named] {
        let mut offers = search().offers(set);
        offers.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut taken: Vec<Cause> = Vec::new();
        for (named, _) in offers {
            let (cause, form) = group[named.candidate];
            if taken.iter().filter(|known| **known == cause).count() < FORMS {
                taken.push(cause);
                keep((cause, form));
            }
        }
    }
    kept
}

/// Relaxations between those of the grid, one cause after the other.
fn refine(problem: &Problem, named: &mut [(Cause, Form)], set: &[Named], noises: &[Filter], by: f64) {
    for place in 0..named.len() {
        if named[place].1.late_s == 0.0 {
            continue;
        }
        let (cause, form) = named[place];
        let mut offered = named.to_vec();
        let near = form.near(by).into_iter().chain([form]);
        let near = near.flat_map(|form| [form, Form { lines: !form.lines, ..form }]);
        let through = form.through().into_iter().filter(|_| matches!(cause, Cause::Covariate(_)));
        offered.extend(near.chain(through).map(|form| (cause, form)));
        let stack = Stack::of(problem, &offered);
        let made = products(&stack, noises);
        let search = Search::new(&stack, &made, &Thought::new());
        let with = |candidate: usize| {
            let mut set = set.to_vec();
            set[place].candidate = candidate;
            search.evidence(&set)
        };
        let tried = std::iter::once(place).chain(named.len()..offered.len());
        if let Some(best) = tried.max_by(|a, b| with(*a).total_cmp(&with(*b))) {
            named[place] = offered[best];
        }
    }
}

/// ln of the odds of the set with and without each of some parts of it, less the most that they lose where the answer to the
/// field is held, any share of the noise being the reference's.
fn gains(
    problem: &Problem,
    named: &[(Cause, Form)],
    all: &[Named],
    noises: &[Filter],
    thought: &Thought,
    parts: &[Vec<usize>],
) -> Vec<f64> {
    if named.is_empty() {
        return Vec::new();
    }
    let without = |out: &Vec<usize>| -> Vec<Named> {
        all.iter().filter(|one| !out.contains(&one.candidate)).cloned().collect()
    };
    let gain = |search: &Search<'_>, out: &Vec<usize>| search.evidence(all) - search.evidence(&without(out));
    let stack = Stack::of(problem, named);
    let made = products(&stack, noises);
    let search = Search::new(&stack, &made, thought);
    let mut gains: Vec<f64> = parts.iter().map(|out| gain(&search, out)).collect();
    if problem.noisy == 0 {
        return gains;
    }
    let plain = problem.plain();
    let mut stack = Stack::of(&plain, named);
    stack.shade(plain.noisy);
    let made = products(&stack, noises);
    let search = Search::new(&stack, &made, thought);
    let free: Vec<f64> = parts.iter().map(|out| gain(&search, out)).collect();
    let mut lost = vec![0.0_f64; parts.len()];
    for share in 0..=SHARES {
        let share = f64::from(share) / f64::from(SHARES);
        let of = |channel: usize| held(&plain, &stack, &made, (channel, all), share);
        let of_channels: Vec<Vec<Product>> = (0..stack.y.len()).map(of).collect();
        let of_channels = of_channels.iter().map(Vec::as_slice).collect();
        let beside = (&stack, &stack.base[plain.noisy..]);
        let search = Search::of_channels(beside, of_channels, thought);
        for ((lost, free), out) in lost.iter_mut().zip(&free).zip(parts) {
            *lost = lost.max(free - gain(&search, out));
        }
    }
    gains.iter_mut().zip(lost).for_each(|(gain, lost)| *gain -= lost);
    gains
}
