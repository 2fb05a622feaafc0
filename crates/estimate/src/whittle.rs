//! Flicker and white noise from periodograms of several series of one channel, by maximum likelihood.

use crate::Error;
use crate::periodogram::Periodogram;
use crate::scoring::{Likelihood, Optimum};
use crate::stats::chi_squared_p;

mod estimate;
mod likelihood;
mod report;

pub use estimate::Estimate;
pub use likelihood::White;
pub(crate) use likelihood::{EXPONENTS, LONGEST};
pub use report::WhittleFit;

use likelihood::{Data, Model};
use report::report;

/// Twice the gain in log likelihood that flicker has to bring. By simulation white noise alone reaches it
/// with a probability of 1 % in three series together and of 0.5 % in one.
pub(crate) const FLICKER: f64 = 7.7;
/// A restriction of the white noise is dropped below this probability.
const RESTRICTED: f64 = 0.01;

/// Fits A, α and the white noise to the periodograms of one channel by maximum likelihood on the ordinates I,
///
/// −ln L = Σ count (ln P(f) + I/P(f)).
///
/// Flicker is the same in all series; a series has none below one over its length. Of the white noise one rms
/// of a reading serves for all unless the likelihood ratio against each its own has a probability below 1 %,
/// then one density if that has not, then each its own. The uncertainties are those of the Fisher
/// information: they hold for Gaussian noise whose density changes little over one over the length of a
/// series, and leave out the choice among models.
///
/// Of 1000 series cut out of longer records the 95 % intervals of A and α held the truth in 94 to 96 % for α
/// = 1, 1.4 and 1.8, that of the white noise in 93 to 97 %.
///
/// Source: P. Whittle, Estimation and information in stationary time series, Ark. Mat. 2 (1953) 423–434.
///
/// Errors: [`Error::TooFew`] without more ordinates than unknowns, [`Error::Series`] for ordinates that
/// are not finite or a series that does not vary, [`Error::NotConverged`] without a maximum.
pub fn fit(series: &[Periodogram]) -> Result<WhittleFit, Error> {
    // Of one series the three forms are the same.
    if let [_] = series {
        return fit_with(series, White::PerReading);
    }
    let data = Data::of(series)?;
    let [reading, density, each] = [White::PerReading, White::Density, White::Each];
    let models = [reading, density, each].map(|white| Model::new(&data, white));
    let (by_reading, by_density) = (models[0].best(&[])?, models[1].best(&[])?);
    let starts = [(0, &by_reading), (1, &by_density)];
    let starts = starts.map(|(number, found)| models[2].spread(&models[number], &found.theta));
    let found = [by_reading, by_density, models[2].best(&starts)?];
    let chosen = least_restricted(&found, series.len());
    if shows_flicker(&models[chosen], &found[chosen]) {
        return report(&models[chosen], &found[chosen]);
    }
    let found = models.each_ref().map(without_flicker);
    let chosen = least_restricted(&found, series.len());
    report(&models[chosen], &found[chosen])
}

/// The same with the form of the white noise as told.
///
/// Errors: as [`fit`].
pub fn fit_with(series: &[Periodogram], white: White) -> Result<WhittleFit, Error> {
    let data = Data::of(series)?;
    let model = Model::new(&data, white);
    let found = model.best(&[])?;
    let found = if shows_flicker(&model, &found) { found } else { without_flicker(&model) };
    report(&model, &found)
}

/// The first of the forms, by reading, by density, each, that the likelihood ratio against the last allows.
fn least_restricted([reading, density, each]: &[Optimum; 3], series: usize) -> usize {
    let allows = |form: &Optimum| {
        chi_squared_p(2.0 * (form.cost - each.cost).max(0.0), series as f64 - 1.0) > RESTRICTED
    };
    [reading, density].into_iter().position(allows).unwrap_or(2)
}

fn without_flicker(model: &Model) -> Optimum {
    let theta = model.white_only();
    Optimum { cost: model.cost(&theta), theta }
}

fn shows_flicker(model: &Model, found: &Optimum) -> bool {
    2.0 * (without_flicker(model).cost - found.cost) > FLICKER
}
