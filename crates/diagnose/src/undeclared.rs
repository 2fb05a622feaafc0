//! Noise that nobody declared is estimated from a residual that has in it what is to be found: slow effects
//! pass for slow noise. So it is first estimated from what the best names leave when all noise is taken for
//! white; what is found then counts where it makes the readings that much more likely than slow noise alone does.

use common::Document;

use crate::course::{self, Ground};
use crate::fit::{Fit, Fitter};
use crate::model::Model;
use crate::search::Searcher;
use crate::whitening::NoiseModel;
use crate::{Error, Outcome};

/// Searches, fits and judges, with noise that is declared or not.
pub fn search(
    document: &Document,
    model: &Model<'_>,
    searcher: &mut Searcher<'_>,
    before: Vec<f64>,
    (base, base_noise): (Fit, NoiseModel),
    told: &dyn Fn(&str),
) -> Result<Outcome, Error> {
    let slow = (0..model.observed.channels.len()).any(|channel| base_noise.remembers(channel));
    if base_noise.known == 0.0 && slow {
        told("searching with less slow noise");
        if let Some(noise) = beside_names(document, model, searcher, &base)? {
            let fit = Fitter { model, noise: &noise }.refine(&base.state)?;
            let other = course::search(document, model, searcher, before.clone(), (fit, noise), told)?;
            let likelier = other.fit.log_likelihood(&other.noise) - base.log_likelihood(&base_noise);
            if !other.found.is_empty() && likelier > cost(searcher, model, &other) {
                let first = searcher.look(&Fitter { model, noise: &base_noise }, &base)?;
                return Ok(Outcome { base, base_noise, first, ..other });
            }
        }
    }
    course::search(document, model, searcher, before, (base, base_noise), told)
}

/// The noise of what the best names leave, all noise taken for white; None where there are no names.
fn beside_names(
    document: &Document,
    model: &Model<'_>,
    searcher: &mut Searcher<'_>,
    base: &Fit,
) -> Result<Option<NoiseModel>, Error> {
    let white = NoiseModel::white(document, &model.observed, &base.residual)?;
    let fitter = Fitter { model, noise: &white };
    let fit = fitter.refine(&base.state)?;
    let look = searcher.look(&fitter, &fit)?;
    let events = look.events.clone();
    let ground = Ground { fit, noise: white.clone(), look, codes: Vec::new() };
    let answer = course::weighed(searcher, &fitter, &ground, (&events, &[]))?;
    let used = Some(ground.fit.rank);
    let noise = |left: &[f64]| NoiseModel::of(document, &model.observed, &ground.fit.state, left, used);
    answer.left.as_deref().map(noise).transpose()
}

/// The log likelihood that names must gain: for the number of candidates or rows that were searched, ½
/// ln(readings) for each unknown (the Bayesian information criterion), and the odds of a false claim.
fn cost(searcher: &Searcher<'_>, model: &Model<'_>, outcome: &Outcome) -> f64 {
    let rows = (model.observed.rows as f64).ln();
    let candidates = (searcher.pool().candidates.len() as f64).ln();
    let names: f64 = outcome.found.iter().map(|found| if found.local { rows } else { candidates }).sum();
    let unknowns = outcome.fit.rank.saturating_sub(outcome.base.rank) as f64;
    names + 0.5 * unknowns * rows - searcher.level.ln()
}
