//! Where a search begins. About a calibration that was fitted without large effects they do not add up; and noise
//! that nobody declared is estimated from a residual that has in it what is to be found, for slow effects pass for slow
//! noise. Both are mended by a rough look: sets of names weighed once, the best fitted with the calibration. What is
//! found from there counts where it makes the readings likelier than what the calibration alone leaves.

use common::{Document, Verdict};

use crate::algebra::square;
use crate::course::{self, Ground};
use crate::fit::{Fit, Fitter, restricted};
use crate::model::{Model, State};
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
    /// The noise beside them.
    noise: NoiseModel,
    /// What they are called.
    names: Vec<String>,
    /// The candidates about it, where it is elsewhere.
    pub pool: Option<Pool>,
}

/// A start from which more can be found; None where the calibration fitted again is as good.
pub fn of(
    document: &Document,
    model: &Model<'_>,
    searcher: &mut Searcher,
    (base, base_noise): (&Fit, &NoiseModel),
    pools: &dyn Fn(&State) -> Result<Pool, Error>,
) -> Result<Option<Approach>, Error> {
    let declared = base_noise.known > 0.0;
    let slow = (0..model.observed.channels.len()).any(|channel| base_noise.remembers(channel));
    let noise = match declared {
        true => base_noise.clone(),
        false => NoiseModel::white(document, &model.observed, &base.residual)?,
    };
    let left = square(&base.residual) / base.residual.len().max(1) as f64;
    let is_large = left > LARGE * LARGE * noise.variance();
    if !is_large && (declared || !slow) {
        return Ok(None);
    }
    let fitter = Fitter { model, noise: &noise };
    let fit = if declared { base.clone() } else { fitter.refine(&base.state)? };
    let look = searcher.look(&fitter, &fit)?;
    let events = look.events.clone();
    let ground = Ground { fit, noise: noise.clone(), look, codes: Vec::new() };
    let answer = course::weighed(searcher, &fitter, &ground, &events, &[])?;
    if answer.names.is_empty() {
        return Ok(None);
    }
    let additions: Vec<Addition> = answer.names.iter().flat_map(|name| name.additions.clone()).collect();
    let near = match course::beside(model, &ground, &additions, None) {
        Err(Error::Unanswerable(_)) => return Ok(None),
        near => near?,
    };
    let noise = if declared { noise } else { restricted(document, model, &near.state, &near.residual)? };
    let state =
        if is_large { State { base: near.state.base, ..base.state.clone() } } else { base.state.clone() };
    let fitter = Fitter { model, noise: &noise };
    let fit = if is_large { fitter.at(&state)? } else { fitter.refine(&state)? };
    let pool = is_large.then(|| pools(&state)).transpose()?;
    let names = answer.names.iter().map(|name| name.name.clone()).collect();
    Ok(Some(Approach { fit, noise, names, pool }))
}

impl Approach {
    /// What is found from here; None where that counts for less than what the calibration alone leaves.
    pub fn search(
        &self,
        document: &Document,
        model: &Model<'_>,
        searcher: &mut Searcher,
        before: Vec<f64>,
        (base, base_noise): (&Fit, &NoiseModel),
        told: &dyn Fn(&str),
    ) -> Result<Option<Outcome>, Error> {
        let start = (self.fit.clone(), self.noise.clone());
        let found = course::search(document, model, searcher, before, start, self.names.clone(), told)?;
        let is_named = !matches!(found.verdict, Verdict::Unexplained | Verdict::Agrees);
        let likelier = found.fit.log_likelihood(&found.noise) - base.log_likelihood(base_noise);
        if !is_named || found.found.is_empty() || likelier < cost(searcher, model, (base, &found)) {
            return Ok(None);
        }
        let first = searcher.look(&Fitter { model, noise: base_noise }, base)?;
        Ok(Some(Outcome { base: base.clone(), base_noise: base_noise.clone(), first, ..found }))
    }
}

/// The log likelihood that names must gain: for the number of candidates or rows that were searched, ½
/// ln(readings) for each unknown (the Bayesian information criterion), and the odds of a false claim.
fn cost(searcher: &Searcher, model: &Model<'_>, (base, outcome): (&Fit, &Outcome)) -> f64 {
    let rows = (model.observed.rows as f64).ln();
    let candidates = (searcher.pool.candidates.len() as f64).ln();
    let names: f64 = outcome.found.iter().map(|found| if found.local { rows } else { candidates }).sum();
    let unknowns = outcome.fit.rank.saturating_sub(base.rank) as f64;
    names + 0.5 * unknowns * rows - searcher.level.ln()
}
