//! From a problem to its explanation.

use estimate::Error;
use estimate::stats::rms;

use crate::amplitude::{self, Amplitude, Fitted};
use crate::form::Form;
use crate::held_out::{self, HeldOut};
use crate::problem::{Cause, Problem};
use crate::search::Rival;
use crate::select::{Screened, Selected};
use crate::stack::Stack;

/// A cause that should have one amplitude in all channels is none where one explains less than this share.
const ALIKE: f64 = 0.75;

/// What explains a problem.
pub struct Explained {
    /// The causes of the best set, with their amplitudes.
    pub causes: Vec<Amplitude>,
    /// ln of the odds of the set with and without each of them.
    pub gains: Vec<f64>,
    /// By how much each lowers the rms of readings that are left out.
    pub held_out_gains: Vec<f64>,
    /// The probability of each of them among all sets that were weighed.
    pub probabilities: Vec<f64>,
    /// Sets of causes that were weighed, the most probable first.
    pub rivals: Vec<Rival>,
    /// The coefficients of the base's columns in each channel, with their standard uncertainties.
    pub base: Vec<Vec<(f64, f64)>>,
    /// What plain least squares on the base alone leave of each channel.
    pub before: Vec<Vec<f64>>,
    /// What they leave with the causes.
    pub residual: Vec<Vec<f64>>,
    /// What each cause contributes to each channel.
    pub contributions: Vec<Vec<Vec<f64>>>,
    /// The rms of readings that were left out.
    pub held_out: HeldOut,
    /// The candidates that the rivals' terms number: first the named ones.
    pub offered: Vec<(Cause, Form)>,
}

impl Explained {
    /// The same without a cause that is told apart.
    pub fn without(&mut self, cause: Cause) {
        if let Some(place) = self.causes.iter().position(|one| one.cause == cause) {
            self.causes.remove(place);
            self.gains.remove(place);
            self.held_out_gains.remove(place);
            self.probabilities.remove(place);
            self.contributions.remove(place);
        }
        let mut rivals: Vec<Rival> = Vec::new();
        for mut set in self.rivals.drain(..) {
            set.causes.retain(|known| *known != cause);
            match rivals.iter_mut().find(|known| known.causes == set.causes) {
                Some(known) => known.probability += set.probability,
                None => rivals.push(set),
            }
        }
        rivals.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        self.rivals = rivals;
    }
}

/// Explains a problem; `told` hears what is being done.
///
/// Errors: times out of order.
pub fn explain(problem: &Problem, told: &dyn Fn(&str)) -> Result<Explained, Error> {
    told("weighing sets of causes");
    let (selected, fitted, gains, predicted) = predictive(problem)?;
    told("predicting readings that are left out");
    let offered = [&selected.named[..], &selected.offered].concat();
    let held_out = held_out::held_out(&Stack::of(problem, &offered), predicted)?;
    let probability = |cause: Cause| -> f64 {
        selected.rivals.iter().filter(|set| set.causes.contains(&cause)).map(|set| set.probability).sum()
    };
    let probabilities = selected.named.iter().map(|(cause, _)| probability(*cause)).collect();
    Ok(Explained {
        causes: fitted.amplitudes,
        gains: selected.gains,
        held_out_gains: gains,
        probabilities,
        rivals: selected.rivals,
        base: fitted.base,
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
    let screened = Screened::of(part)?;
    let mut out: Vec<Cause> = Vec::new();
    loop {
        let selected = screened.select(&out)?;
        let fitted = amplitude::fit(part, &selected.named, &selected.noises);
        let sets: Vec<Option<usize>> = (0..selected.named.len()).map(Some).chain([None]).collect();
        let mut all = held_out::predicted(part, &fitted, &sets)?;
        let with = all.swap_remove(selected.named.len());
        let (mut gains, before) = (Vec::new(), out.len());
        for (number, without) in all.iter().enumerate() {
            let alike = fitted.amplitudes[number].alike.unwrap_or(1.0);
            if lower(without, &with) <= 0.0 || alike < ALIKE {
                out.push(selected.named[number].0);
            }
            gains.push(rms(without) - rms(&with));
        }
        if out.len() == before {
            return Ok((selected, fitted, gains, with));
        }
    }
}

/// ln of the factor by which rms are lower, all channels together.
fn lower(before: &[f64], after: &[f64]) -> f64 {
    before.iter().zip(after).map(|(before, after)| (before / after).ln()).sum()
}
