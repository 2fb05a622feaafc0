//! From all causes in all forms to the best set: screened on some of the rows, decided on all of them.

use common::Noise;
use estimate::Error;

use crate::form::Form;
use crate::noises;
use crate::problem::{Cause, Problem};
use crate::products::{Product, products};
use crate::reference::Shares;
use crate::search::{Named, Rival, Search};
use crate::stack::Stack;

/// Up to so many rows all forms are weighed on all rows; beyond, they are screened on so many in so many blocks.
const ROWS: usize = 8_192;
const BLOCKS: usize = 16;
/// Forms of a cause that are weighed on all rows.
const FORMS: usize = 5;
/// Most columns that are screened at once.
const AT_ONCE: usize = 160;
/// A refined relaxation is between those of the grid by these factors.
const NEARER: [f64; 2] = [1.2, 1.06];
/// ln of the odds that a name keeps at every share of the noise that the reference may have.
const STANDS: f64 = 0.0;

/// The best set of causes, and how likely it is.
pub struct Selected {
    /// Each cause in its form, and the channels on which it shows.
    pub named: Vec<(Cause, Form, Vec<bool>)>,
    /// ln of the odds of the set with and without each of them.
    pub gains: Vec<f64>,
    /// All sets that were weighed.
    pub rivals: Vec<Rival>,
    /// The forms that were weighed on all rows.
    pub offered: Vec<(Cause, Form)>,
}

/// Weighs all causes of a problem.
///
/// # Errors
///
/// Times out of order.
pub fn select(problem: &Problem) -> Result<Selected, Error> {
    let mut causes = problem.causes();
    let all = causes.len();
    loop {
        let selected = among(problem, &causes, all)?;
        // What noise of the reference may imitate is no name.
        match selected.gains.iter().position(|gain| *gain <= STANDS) {
            None => return Ok(selected),
            Some(weakest) => {
                let out = selected.named[weakest].0;
                causes.retain(|cause| *cause != out);
            }
        }
    }
}

fn among(problem: &Problem, causes: &[Cause], all: usize) -> Result<Selected, Error> {
    let noises = noises::grid(problem.step_s());
    let forms = |cause: Cause| Form::all(problem, cause);
    let mut offered: Vec<(Cause, Form)> =
        causes.iter().flat_map(|cause| forms(*cause).into_iter().map(|form| (*cause, form))).collect();
    let count = |cause: Cause| forms(cause).len();
    if problem.rows() > ROWS || offered.len() > AT_ONCE {
        let thin = problem.at(&thinned(problem.rows()));
        offered = screened(&thin, &offered, &noises, all, &count)?;
    }
    let stack = Stack::of(problem, &offered);
    let made = products(&problem.time_s, &stack.columns, &noises)?;
    let of_channels = vec![made.as_slice(); stack.y.len()];
    let (set, rivals) = Search::new(&stack, of_channels, problem.rows(), all, &count).best();
    let mut named: Vec<(Cause, Form, Vec<bool>)> = set
        .named
        .iter()
        .map(|one| {
            let candidate = &stack.candidates[one.candidate];
            (candidate.cause, candidate.form, one.channels.clone())
        })
        .collect();
    drop(stack);
    for by in NEARER {
        refine(problem, &mut named, &noises, by)?;
    }
    let gains = gains(problem, &named, &noises, all, &count)?;
    Ok(Selected { named, gains, rivals, offered })
}

/// Rows in blocks that are spread over all.
fn thinned(rows: usize) -> Vec<usize> {
    let each = ROWS / BLOCKS;
    if rows <= ROWS {
        return (0..rows).collect();
    }
    let from = |block: usize| block * (rows - each) / (BLOCKS - 1);
    (0..BLOCKS).flat_map(|block| from(block)..from(block) + each).collect()
}

/// The forms of each cause that explain most by themselves and beside the best set.
fn screened(
    thin: &Problem,
    offered: &[(Cause, Form)],
    noises: &[Noise],
    causes: usize,
    count: &dyn Fn(Cause) -> usize,
) -> Result<Vec<(Cause, Form)>, Error> {
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
        kept.extend(best_forms(thin, group, noises, causes, count)?);
    }
    Ok(kept)
}

fn best_forms(
    thin: &Problem,
    group: &[(Cause, Form)],
    noises: &[Noise],
    causes: usize,
    count: &dyn Fn(Cause) -> usize,
) -> Result<Vec<(Cause, Form)>, Error> {
    let stack = Stack::of(thin, group);
    let made = products(&thin.time_s, &stack.columns, noises)?;
    let search = || {
        let of_channels: Vec<&[Product]> = vec![made.as_slice(); stack.y.len()];
        Search::new(&stack, of_channels, thin.rows(), causes, count)
    };
    let (best, _) = search().best();
    let mut kept: Vec<(Cause, Form)> = Vec::new();
    let mut keep = |one: (Cause, Form)| {
        if !kept.contains(&one) {
            kept.push(one);
        }
    };
    for named in &best.named {
        keep(group[named.candidate]);
    }
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
    Ok(kept)
}

/// Relaxations between those of the grid, one cause after the other.
fn refine(
    problem: &Problem,
    named: &mut [(Cause, Form, Vec<bool>)],
    noises: &[Noise],
    by: f64,
) -> Result<(), Error> {
    for place in 0..named.len() {
        if named[place].1.late_s == 0.0 {
            continue;
        }
        let (cause, form, _) = named[place].clone();
        let mut offered: Vec<(Cause, Form)> = named.iter().map(|(cause, form, _)| (*cause, *form)).collect();
        offered.extend(form.near(by).into_iter().map(|form| (cause, form)));
        let stack = Stack::of(problem, &offered);
        let made = products(&problem.time_s, &stack.columns, noises)?;
        let of_channels = vec![made.as_slice(); stack.y.len()];
        let search = Search::new(&stack, of_channels, problem.rows(), 1, &|_| 1);
        let with = |candidate: usize| {
            let of = |(at, (_, _, channels)): (usize, &(Cause, Form, Vec<bool>))| Named {
                candidate: if at == place { candidate } else { at },
                channels: channels.clone(),
            };
            search.evidence(&named.iter().enumerate().map(of).collect::<Vec<_>>())
        };
        let best = [place]
            .into_iter()
            .chain(named.len()..offered.len())
            .max_by(|a, b| with(*a).total_cmp(&with(*b)));
        if let Some(best) = best {
            named[place].1 = offered[best].1;
        }
    }
    Ok(())
}

/// ln of the odds of the set with and without each cause, the least over all shares of the noise that may be
/// the reference's.
fn gains(
    problem: &Problem,
    named: &[(Cause, Form, Vec<bool>)],
    noises: &[Noise],
    causes: usize,
    count: &dyn Fn(Cause) -> usize,
) -> Result<Vec<f64>, Error> {
    if named.is_empty() {
        return Ok(Vec::new());
    }
    let offered: Vec<(Cause, Form)> = named.iter().map(|(cause, form, _)| (*cause, *form)).collect();
    let mut stack = Stack::of(problem, &offered);
    stack.shade(problem);
    let made = products(&problem.time_s, &stack.columns, noises)?;
    let all: Vec<Named> = named
        .iter()
        .enumerate()
        .map(|(candidate, (_, _, channels))| Named { candidate, channels: channels.clone() })
        .collect();
    let shares = Shares::of(problem, &stack, &made, &all);
    let mut least = vec![f64::INFINITY; named.len()];
    for corrected in shares.each() {
        let of_channels = corrected.iter().map(Vec::as_slice).collect();
        let search = Search::new(&stack, of_channels, problem.rows(), causes, count);
        let whole = search.evidence(&all);
        for (out, least) in least.iter_mut().enumerate() {
            let mut rest = all.clone();
            rest.remove(out);
            *least = least.min(whole - search.evidence(&rest));
        }
    }
    Ok(least)
}
