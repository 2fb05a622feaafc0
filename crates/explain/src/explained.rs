//! From a problem to its explanation: causes first, then events in what they leave, until neither changes.

use estimate::Error;

use crate::amplitude::{self, Amplitude, Fitted, Step};
use crate::events::{self, Event, Left};
use crate::form::Form;
use crate::held_out::{HeldOut, held_out};
use crate::noises;
use crate::predicted;
use crate::problem::{Cause, Problem};
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
    /// ln of the odds of the set with and without each of them.
    pub gains: Vec<f64>,
    /// The most probable form of noise of each channel.
    pub(crate) noises: Vec<noises::Form>,
    /// By how much each lowers the rms of readings that are left out.
    pub held_out_gains: Vec<f64>,
    /// The probability of each of them among all sets that were weighed.
    pub probabilities: Vec<f64>,
    /// Sets of causes that were weighed, the most probable first.
    pub rivals: Vec<Rival>,
    /// The coefficients of the base's columns in each channel, with their standard uncertainties.
    pub base: Vec<Vec<(f64, f64)>>,
    /// Changes of level in what they leave.
    pub steps: Vec<Step>,
    /// Rows that are off by themselves.
    pub off: Vec<bool>,
    /// What plain least squares on the base alone leave of each channel, in the rows that are not off.
    pub before: Vec<Vec<f64>>,
    /// What they leave with the causes and the steps.
    pub residual: Vec<Vec<f64>>,
    /// What each cause contributes to each channel in these rows.
    pub contributions: Vec<Vec<Vec<f64>>>,
    /// The rms of readings that were left out.
    pub held_out: HeldOut,
    /// The candidates that the rivals' terms number: first the named ones.
    pub offered: Vec<(Cause, Form)>,
}

impl Explained {
    /// The same without a cause that is told apart.
    pub(crate) fn without(&mut self, cause: Cause) {
        if let Some(place) = self.causes.iter().position(|one| one.cause == cause) {
            self.causes.remove(place);
            self.gains.remove(place);
            self.held_out_gains.remove(place);
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
    let (mut part, mut rows, mut selected, mut fitted, mut gains, mut predicted);
    let mut round = 0;
    loop {
        round += 1;
        rows = (0..problem.rows()).filter(|row| !off[*row]).collect::<Vec<usize>>();
        told(&format!("weighing what was recorded beside, round {round}"));
        // Columns first: what was a step in the round before may be none beside the right column.
        part = problem.at(&rows);
        (selected, fitted, gains, predicted) = predictive(&part)?;
        told("looking for steps and single readings that are off");
        let spikes;
        (fitted, predicted, spikes) = eventful(&mut part, &mut selected, fitted, predicted)?;
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
    let named = selected.named.iter().map(|(cause, form, _)| (*cause, *form));
    let offered: Vec<(Cause, Form)> = named.chain(selected.offered.iter().copied()).collect();
    let held_out = HeldOut { named: predicted, ..held_out(&Stack::of(&part, &offered)) };
    let probability = |cause: Cause| -> f64 {
        selected.rivals.iter().filter(|set| set.causes.contains(&cause)).map(|set| set.probability).sum()
    };
    let probabilities = selected.named.iter().map(|(cause, ..)| probability(*cause)).collect();
    Ok(Explained {
        steps: fitted.sizes(&part, &rows),
        causes: fitted.amplitudes,
        gains: selected.gains,
        noises: fitted.noise,
        held_out_gains: gains,
        probabilities,
        rivals: selected.rivals,
        base: fitted.base,
        off,
        before: fitted.before,
        residual: fitted.after,
        contributions: fitted.contributions,
        held_out,
        offered,
    })
}

/// The best set of causes of which each predicts readings that are left out, the fit of it, what is gained by each of
/// them, and the rms of each channel's readings that are left out.
fn predictive(part: &Problem) -> Result<(Selected, Fitted, Vec<f64>, Vec<f64>), Error> {
    let mut causes = part.causes();
    loop {
        let selected = select(part, &causes)?;
        let fitted = fit(part, &selected)?;
        let sets: Vec<Option<usize>> = (0..selected.named.len()).map(Some).chain([None]).collect();
        let mut all = predicted::rms(part, &fitted, &sets)?;
        let with = all.swap_remove(selected.named.len());
        let mut gains = Vec::new();
        for (number, without) in all.iter().enumerate() {
            if lower(without, &with) <= 0.0 {
                causes.retain(|cause| *cause != selected.named[number].0);
            }
            gains.push(mean(without) - mean(&with));
        }
        if gains.len() == selected.named.iter().filter(|(cause, ..)| causes.contains(cause)).count() {
            return Ok((selected, fitted, gains, with));
        }
    }
}

/// Root of the mean of the squares.
fn mean(rms: &[f64]) -> f64 {
    (rms.iter().map(|rms| rms * rms).sum::<f64>() / rms.len().max(1) as f64).sqrt()
}

fn fit(part: &Problem, selected: &Selected) -> Result<Fitted, Error> {
    let named: Vec<(Cause, Form)> = selected.named.iter().map(|(cause, form, _)| (*cause, *form)).collect();
    amplitude::fit(part, &named, &selected.noises)
}

/// Adds steps one at a time to the base, the causes weighed again beside them, until none is clear: the fit, the rms of
/// readings that are left out, and the rows that are off by themselves.
fn eventful(
    part: &mut Problem,
    selected: &mut Selected,
    mut fitted: Fitted,
    mut held_out: Vec<f64>,
) -> Result<(Fitted, Vec<f64>, Vec<usize>), Error> {
    for _ in 0..EVENTS {
        let found = clearest(part, &fitted)?;
        let Some(Event::Step(row)) = found.first().copied() else {
            let row = |event: &Event| if let Event::Spike(row) = event { Some(*row) } else { None };
            return Ok((fitted, held_out, found.iter().filter_map(row).collect()));
        };
        let before = part.steps.clone();
        if before.contains(&row) {
            break;
        }
        part.steps.push(row);
        part.steps.sort_unstable();
        let with = fit(part, selected)?;
        let predicted = predicted::rms(part, &with, &[None])?.swap_remove(0);
        // A level that does not help to predict other readings is none, nor one that the fit does not know.
        if lower(&held_out, &predicted) <= 0.0 || !with.knows_steps(part.rows()) {
            part.steps = before;
            break;
        }
        (fitted, held_out) = (with, predicted);
    }
    Ok((fitted, held_out, Vec::new()))
}

/// ln of the factor by which rms are lower, all channels together.
fn lower(before: &[f64], after: &[f64]) -> f64 {
    before.iter().zip(after).map(|(before, after)| (before / after).ln()).sum()
}

fn clearest(part: &Problem, fitted: &Fitted) -> Result<Vec<Event>, Error> {
    let filters: Vec<_> =
        fitted.noise.iter().map(|noise| noise.whitening(&part.time_s)).collect::<Result<_, _>>()?;
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
