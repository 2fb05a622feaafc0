//! Which terms the readings ask for: taken one by one, the likeliest first, while the evidence is for them.

use crate::Error;
use crate::fit::{Fit, Flight};
use crate::terms::Direction;
use faer::linalg::solvers::Solve;
use faer::{Col, Mat, Side};

/// ln of the posterior odds from which a term is taken.
const TAKEN: f64 = 3.0;
const MOST: usize = 8;

pub struct Chosen<T> {
    /// Each with ln of its Bayes factor.
    pub terms: Vec<(T, f64)>,
    /// Terms that were likely before one was taken, and are not beside it: that one, the other, and ln of the Bayes factor
    /// of the other.
    pub rivals: Vec<(T, T, f64)>,
    pub fit: Fit,
}

/// Takes terms beside directions that are fitted; `may` says whether a term is looked at beside others.
/// Errors: what the rows do not determine.
pub fn choose<T: Copy + PartialEq>(
    flight: &Flight,
    (mut directions, mut fit): (Vec<Direction>, Fit),
    candidates: &[(T, Vec<Direction>)],
    may: impl Fn(T, &[(T, f64)]) -> bool,
) -> Result<Chosen<T>, Error> {
    let mut terms: Vec<(T, f64)> = Vec::new();
    let mut rivals = Vec::new();
    let mut still: Vec<T> = Vec::new();
    while terms.len() < MOST {
        let mut likely: Vec<(&(T, Vec<Direction>), f64)> = Vec::new();
        let weighted = flight.weighted(&fit.variances);
        let is_new = |term: T| !terms.iter().any(|(one, _)| *one == term) && may(term, &terms);
        for candidate in candidates.iter().filter(|(term, _)| is_new(*term)) {
            // What does not vary cannot be determined, and is not a term.
            let with = flight.fit(&[&directions[..], &candidate.1].concat(), fit.variances, &weighted);
            let factor = with.ok().and_then(|with| log_bayes_factor(flight, &with, directions.len()));
            likely.extend(factor.filter(|factor| *factor > TAKEN).map(|factor| (candidate, factor)));
        }
        likely.sort_by(|a, b| b.1.total_cmp(&a.1));
        still = likely.iter().map(|((term, _), _)| *term).collect();
        let many = (candidates.len() as f64).ln();
        let Some(((term, more), factor)) = likely.first().filter(|(_, factor)| factor - many > TAKEN) else {
            break;
        };
        let longer = [&directions[..], more].concat();
        let Ok(next) = flight.settled(&longer, &fit.variances) else { break };
        rivals.extend(likely[1..].iter().map(|((other, _), ln)| (*term, *other, *ln)));
        terms.push((*term, *factor));
        (directions, fit) = (longer, next);
    }
    // Each once, where it was likeliest, and only what is not likely any more.
    rivals.sort_by(|a, b| b.2.total_cmp(&a.2));
    let mut told: Vec<T> = terms.iter().map(|(taken, _)| *taken).chain(still).collect();
    rivals.retain(|(_, other, _)| {
        let is_new = !told.contains(other);
        told.push(*other);
        is_new
    });
    Ok(Chosen { terms, rivals, fit })
}

/// ln of the Bayes factor for the parameters from place `own` on: Schwarz's criterion of windows of time, with the
/// likelihood of Student's t, as a covariance by few windows is not well known. The smaller of those by few correlated windows
/// and by many.
fn log_bayes_factor(flight: &Flight, with: &Fit, own: usize) -> Option<f64> {
    let count = with.values.len() - own;
    // Windows do not tell the covariance of as many parameters.
    if 2 * count > flight.windows() {
        return None;
    }
    let part = |whole: &Mat<f64>| whole.submatrix(own, own, count, count).to_owned();
    let values = Col::from_fn(count, |k| with.values[own + k]);
    let of = |(covariance, freedom): (&Mat<f64>, f64)| {
        let squares = values.transpose() * part(covariance).llt(Side::Lower).ok()?.solve(&values);
        let gain = (freedom + count as f64) * (squares / freedom).ln_1p();
        Some(0.5 * (gain - count as f64 * (flight.windows() as f64).ln()))
    };
    let both = [&with.covariance, &with.short].into_iter().zip(flight.freedom()).map(of);
    both.collect::<Option<Vec<f64>>>()?.into_iter().reduce(f64::min)
}
