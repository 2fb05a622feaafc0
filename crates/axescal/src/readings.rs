//! Readings one by one: leverage, leave-one-out, and those that do not belong to the rest.

use estimate::influence;
use estimate::{Fit, Options as Iteration, Problem};

use crate::{AxesProblem, AxesState, Error};

/// A reading is called doubtful below this adjusted probability.
const DOUBTFUL_P: f64 = 0.01;
/// More doubtful readings than this are not single faults.
const MOST_DOUBTFUL: usize = 20;

/// A reading that does not belong to the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubt {
    pub reading: usize,
    /// Reading less the prediction made without it, nT.
    pub leave_one_out_nt: f64,
    /// That over its standard deviation, estimated without it.
    pub t: f64,
    /// Probability that the largest of all is so far out.
    pub p_adjusted: f64,
}

/// Takes out the reading that is furthest from the prediction made without it, as long as that is beyond
/// chance, and fits again: a large fault hides smaller ones, so they are looked for one after the other.
pub fn doubtful(
    problem: &AxesProblem<'_>,
    plain: &Fit<AxesState>,
    declared: bool,
) -> Result<Vec<Doubt>, Error> {
    let count = problem.readings();
    let mut weights = vec![1.0; count];
    let mut found: Vec<Doubt> = Vec::new();
    let mut fit = plain.clone();
    while found.len() < MOST_DOUBTFUL.min(count / 4) {
        let freedom = fit.degrees_of_freedom() - found.len() as f64 - 1.0;
        if freedom < 2.0 {
            break;
        }
        let all = influence::influence(&fit, count, declared, found.len());
        let furthest = (0..count)
            .filter(|i| weights[*i] > 0.0)
            .max_by(|a, b| all[*a].t.abs().total_cmp(&all[*b].t.abs()));
        let Some(reading) = furthest else { break };
        let p_adjusted = influence::adjusted_p(all[reading].t, freedom, count - found.len());
        if p_adjusted >= DOUBTFUL_P {
            break;
        }
        let leave_one_out_nt = all[reading].leave_one_out * problem.own_std_nt(reading);
        found.push(Doubt { reading, leave_one_out_nt, t: all[reading].t, p_adjusted });
        weights[reading] = 0.0;
        fit = estimate::solve(problem, fit.state, Some(&weights), &Iteration::default())?;
    }
    Ok(found)
}
