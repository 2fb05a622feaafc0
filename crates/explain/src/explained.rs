//! From a problem to its explanation: causes first, then events in what they leave, until neither changes.

use estimate::Error;

use crate::amplitude::{self, Amplitude, Fitted, Step};
use crate::events::{self, Event, Left};
use crate::form::Form;
use crate::held_out::{HeldOut, held_out};
use crate::noises;
use crate::problem::{Cause, Problem};
use crate::products::whitening;
use crate::search::Rival;
use crate::select::{Selected, select};
use crate::stack::Stack;

/// Rounds of causes and events, and the most events that are looked for in one.
const ROUNDS: usize = 6;
const EVENTS: usize = 40;

/// What explains a problem.
pub struct Explained {
    /// The causes of the best set, with their amplitudes.
    pub causes: Vec<Amplitude>,
    /// ln of the odds of the set with and without each of them, the least over all noise of the reference.
    pub gains: Vec<f64>,
    /// The probability of each of them among all sets that were weighed.
    pub probabilities: Vec<f64>,
    /// Sets of causes that were weighed, the most probable first.
    pub rivals: Vec<Rival>,
    /// Changes of level in what they leave.
    pub steps: Vec<Step>,
    /// Rows that are off by themselves.
    pub off: Vec<bool>,
    /// What the base alone leaves of each channel, in the rows that are not off.
    pub before: Vec<Vec<f64>>,
    /// What is left of each channel in these rows.
    pub residual: Vec<Vec<f64>>,
    /// What each cause contributes to each channel in these rows.
    pub contributions: Vec<Vec<Vec<f64>>>,
    /// The rms of readings that were left out.
    pub held_out: HeldOut,
    /// The candidates that the rivals' terms number.
    pub offered: Vec<(Cause, Form)>,
}

impl Explained {
    /// The same without a cause that is told apart.
    pub(crate) fn without(&mut self, cause: Cause) {
        if let Some(place) = self.causes.iter().position(|one| one.cause == cause) {
            self.causes.remove(place);
            self.gains.remove(place);
            self.probabilities.remove(place);
            self.contributions.remove(place);
        }
        for set in &mut self.rivals {
            set.causes.retain(|known| *known != cause);
        }
    }
}

/// Explains a problem; `told` hears what is being done.
///
/// # Errors
///
/// Times out of order.
pub fn explain(problem: &Problem, told: &dyn Fn(&str)) -> Result<Explained, Error> {
    let mut off = vec![false; problem.rows()];
    let mut steps: Vec<usize> = Vec::new();
    let (mut part, mut rows, mut selected, mut fitted);
    let mut round = 0;
    loop {
        round += 1;
        rows = (0..problem.rows()).filter(|row| !off[*row]).collect::<Vec<usize>>();
        told(&format!("weighing what was recorded beside, round {round}"));
        // Columns first: what was a step in the round before may be none beside the right column.
        part = problem.at(&rows);
        selected = select(&part)?;
        fitted = fit(&part, &selected)?;
        told("looking for steps and single readings that are off");
        let spikes;
        (fitted, spikes) = eventful(&mut part, &mut selected, fitted)?;
        let found: Vec<usize> = part.steps.iter().map(|step| rows[*step]).collect();
        spikes.iter().for_each(|spike| off[rows[*spike]] = true);
        let same = found == steps;
        steps = found;
        if (spikes.is_empty() && same) || round == ROUNDS {
            break;
        }
        if spikes.is_empty() && round > 1 {
            break;
        }
    }
    let held_out = predicted(&part, &selected)?;
    let probability = |cause: Cause| -> f64 {
        selected.rivals.iter().filter(|set| set.causes.contains(&cause)).map(|set| set.probability).sum()
    };
    let probabilities = selected.named.iter().map(|(cause, ..)| probability(*cause)).collect();
    Ok(Explained {
        steps: fitted.sizes(&part, &rows),
        causes: fitted.amplitudes,
        gains: selected.gains,
        probabilities,
        rivals: selected.rivals,
        off,
        before: fitted.before,
        residual: fitted.residual,
        contributions: fitted.contributions,
        held_out,
        offered: selected.offered,
    })
}

fn fit(part: &Problem, selected: &Selected) -> Result<Fitted, Error> {
    let named: Vec<(Cause, Form)> = selected.named.iter().map(|(cause, form, _)| (*cause, *form)).collect();
    amplitude::fit(part, &named)
}

/// Adds steps one at a time to the base, the causes weighed again beside them, until none is clear; and the
/// rows that are off by themselves.
fn eventful(
    part: &mut Problem,
    selected: &mut Selected,
    mut fitted: Fitted,
) -> Result<(Fitted, Vec<usize>), Error> {
    for _ in 0..EVENTS {
        let found = clearest(part, &fitted)?;
        let spikes: Vec<usize> = found
            .iter()
            .filter_map(|event| if let Event::Spike(row) = event { Some(*row) } else { None })
            .collect();
        let Some(Event::Step(row)) = found.first() else { return Ok((fitted, spikes)) };
        if part.steps.contains(row) {
            break;
        }
        part.steps.push(*row);
        part.steps.sort_unstable();
        fitted = fit(part, selected)?;
    }
    Ok((fitted, Vec::new()))
}

fn clearest(part: &Problem, fitted: &Fitted) -> Result<Vec<Event>, Error> {
    let noises = noises::grid(part.step_s());
    let filters: Vec<_> = fitted
        .noise
        .iter()
        .map(|noise| whitening(&part.time_s, &noises[*noise]))
        .collect::<Result<_, _>>()?;
    let left: Vec<Left<'_>> = (0..filters.len())
        .map(|channel| Left {
            residual: &fitted.residual[channel],
            columns: fitted.independent(channel),
            filter: &filters[channel],
            variance: fitted.variance[channel],
        })
        .collect();
    events::clearest(&left)
}

/// What the named causes and the rivals predict of readings that are left out.
fn predicted(part: &Problem, selected: &Selected) -> Result<HeldOut, Error> {
    let named = selected.named.iter().map(|(cause, form, _)| (*cause, *form));
    let others = selected.offered.iter().copied();
    let all: Vec<(Cause, Form)> = named.chain(others).collect();
    Ok(held_out(&Stack::of(part, &all), selected.named.len()))
}
