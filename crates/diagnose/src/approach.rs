//! Where a search begins. About a calibration that was fitted without large effects they do not add up; and noise
//! that nobody declared is estimated from a residual that has in it what is to be found, for slow effects pass for slow
//! noise. Both are mended by a rough look: sets of names weighed once, the best fitted with the calibration. What is
//! found from there counts where it makes the readings likelier than what the calibration alone leaves.

use common::Verdict;

use crate::algebra::square;
use crate::course;
use crate::fit::{Fit, Fitter, restricted};
use crate::model::State;
use crate::pool::Pool;
use crate::proposal::Addition;
use crate::search::Searcher;
use crate::whitening::NoiseModel;
use crate::{Error, Outcome};

/// What the calibration fitted again leaves, over the noise, above which effects and calibration do not add up.
const LARGE: f64 = 30.0;

/// A start other than the calibration fitted again, under the noise that is declared or that it leaves.
pub struct Approach {
    /// The calibration that goes with the best names, without them.
    fit: Fit,
    noise: NoiseModel,
    names: Vec<String>,
    pub pool: Option<Pool>,
}

/// A start from which more can be found; None where the calibration fitted again is as good.
pub fn of(
    searcher: &mut Searcher<'_, '_>,
    (base, base_noise): (&Fit, &NoiseModel),
    pools: &dyn Fn(&State) -> Result<Pool, Error>,
) -> Result<Option<Approach>, Error> {
    let model = searcher.model;
    let declared = base_noise.known > 0.0;
    let slow = (0..model.observed.channels.len()).any(|channel| base_noise.remembers(channel));
    let noise = match declared {
        true => base_noise.clone(),
        false => NoiseModel::white(&model.observed, &base.residual)?,
    };
    let left = square(&base.residual) / base.residual.len().max(1) as f64;
    let is_large = left > LARGE * LARGE * noise.variance();
    if !is_large && (declared || !slow) {
        return Ok(None);
    }
    let fitter = Fitter { model, noise: &noise };
    let fit = if declared { base.clone() } else { fitter.refine(&base.state)? };
    let ground = searcher.ground(fit, noise.clone())?;
    let answer = course::weighed(searcher, &ground, &ground.look.events, &[])?;
    if answer.names.is_empty() {
        return Ok(None);
    }
    let additions: Vec<Addition> = answer.names.iter().flat_map(|name| name.additions.clone()).collect();
    let near = match course::beside(model, &ground, &additions, None) {
        Err(Error::Unanswerable(_)) => return Ok(None),
        near => near?,
    };
    let noise = if declared { noise } else { restricted(model, &near.state, &near.residual)? };
    let mut state = base.state.clone();
    if is_large {
        state.base = near.state.base;
    }
    let fitter = Fitter { model, noise: &noise };
    let fit = if is_large { fitter.at(&state)? } else { fitter.refine(&state)? };
    let pool = is_large.then(|| pools(&state)).transpose()?;
    let names = answer.names.into_iter().map(|name| name.name).collect();
    Ok(Some(Approach { fit, noise, names, pool }))
}

impl Approach {
    /// What is found from here; None where that counts for less than what the calibration alone leaves.
    pub fn search(
        self,
        searcher: &mut Searcher<'_, '_>,
        before: Vec<f64>,
        (base, base_noise): (&Fit, &NoiseModel),
    ) -> Result<Option<Outcome>, Error> {
        let found = course::search(searcher, before, (self.fit, self.noise), self.names)?;
        let is_named = !matches!(found.verdict, Verdict::Unexplained | Verdict::Agrees);
        let likelier = found.now.fit.log_likelihood(&found.now.noise) - base.log_likelihood(base_noise);
        if !is_named || found.found.is_empty() || likelier < cost(searcher, base, &found) {
            return Ok(None);
        }
        let base = searcher.ground(base.clone(), base_noise.clone())?;
        Ok(Some(Outcome { base, ..found }))
    }
}

/// The log likelihood that names must gain: for the number of candidates or rows that were searched, ½
/// ln(readings) for each unknown (the Bayesian information criterion), and the odds of a false claim.
fn cost(searcher: &Searcher<'_, '_>, base: &Fit, outcome: &Outcome) -> f64 {
    let rows = (searcher.model.observed.rows as f64).ln();
    let candidates = (searcher.pool.candidates.len() as f64).ln();
    let names: f64 = outcome.found.iter().map(|found| if found.local { rows } else { candidates }).sum();
    let unknowns = outcome.now.fit.rank.saturating_sub(base.rank) as f64;
    names + 0.5 * unknowns * rows - searcher.level.ln()
}
