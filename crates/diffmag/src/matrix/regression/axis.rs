//! The fit of one axis of the test instrument.

use common::{Drift, DriftForm, Quantity};
use estimate::cosine::{self, Errors};
use estimate::dot;
use estimate::hac;
use estimate::periodogram::periodogram;
use estimate::spectral::SpectralFit;
use estimate::stats::mean;
use faer::Mat;

use super::held::{Place, determined, with_held};
use crate::across::Whitened;
use crate::drift::{self, Columns};
use crate::{Error, alike};
use joined::Pair;
use paired::followed::Follows;
use paired::noise::Noise;
use paired::residual::{beside, centred, rest, without};

/// The straight drift stands after the reference's axes, what else there is after it.
const DAYS: usize = 3;
pub const STRAIGHT: usize = DAYS + 1;

pub struct AxisFit {
    /// Weighted coefficients of the reference's x, y, z (nT/nT), of the straight drift (nT/day), where an
    /// exponential drift is demanded of e^(−t/τ) (nT) and of its derivative with respect to ln τ, of the
    /// housekeeping columns that it follows, and of the steps (nT).
    pub fit: SpectralFit,
    pub noise: Noise,
    /// T − R η − drift − steps less its mean, η as weighted, nT.
    pub difference: Vec<f64>,
    /// Mean of T − R η, nT.
    pub offset_nt: f64,
    pub drift: Drift,
    pub follows: Vec<Follows>,
    /// e^(−t/τ) and its derivative with respect to ln τ, where that drift is demanded.
    pub(super) drift_columns: Vec<Vec<f64>>,
    /// Degrees of freedom of the variances of η; infinite where they are not counted.
    pub freedom: [f64; 3],
    /// How many times as wide as under the noise the uncertainties of η are by what is left itself.
    pub wider: f64,
    /// Covariance of η with that of each axis, its own among them: [axis][own element][element there].
    pub across: [[[f64; 3]; 3]; 3],
    pub source: Source,
}

impl AxisFit {
    /// The columns between the straight drift and the steps.
    pub(super) fn further(&self) -> impl Iterator<Item = &Vec<f64>> {
        self.drift_columns.iter().chain(self.follows.iter().flat_map(|follows| &follows.columns))
    }

    /// What it follows, with the coefficients of its columns.
    pub fn followed(&self) -> Vec<(&Follows, Vec<Quantity>)> {
        let mut next = STRAIGHT + self.drift_columns.len();
        let mut of = |follows: &Follows| -> Vec<Quantity> {
            let own = next..next + follows.columns.len();
            next = own.end;
            own.map(|i| Quantity::new(self.fit.weighted[i], self.fit.weighted_covariance[(i, i)].sqrt()))
                .collect()
        };
        self.follows.iter().map(|follows| (follows, of(follows))).collect()
    }

    /// T − R η − drift less its mean of another pair on the same grid, nT.
    pub fn left(&self, pair: &Pair, axis: usize) -> Vec<f64> {
        let days = pair.days();
        let others = std::iter::once(&days).chain(self.further()).map(Vec::as_slice);
        let design: Vec<&[f64]> = pair.reference.iter().map(AsRef::as_ref).chain(others).collect();
        let steps: Vec<Vec<f64>> = pair.step_columns(axis).collect();
        let sizes = &self.fit.weighted[design.len()..];
        rest(&design, &without(&pair.test[axis], &steps, sizes), &self.fit.weighted)
    }
}

/// The source's fit: least squares of the reference's axes alone.
pub struct Source {
    pub fit: SpectralFit,
    /// Standard deviations of the coefficients by Newey and West.
    pub newey_west: Vec<f64>,
    /// T − R η less its mean, nT.
    pub difference: Vec<f64>,
}

/// One axis: the reference's three axes, the drift that the readings demand and the steps, under the noise of
/// what they leave, in the band in which the instruments answer alike.
pub(super) fn one(
    whole: &Columns<'_>,
    follows: &[Follows],
    axis: usize,
) -> Result<(AxisFit, Whitened), Error> {
    let pair = whole.pair;
    let test = &pair.test[axis];
    let mut y = whole.transform(test);
    let base: Vec<&[f64]> = pair.reference.iter().map(AsRef::as_ref).chain([whole.days.as_slice()]).collect();
    let (seen, plain_noise) = plain(whole, &base, test, &y)?;
    let kept = alike::band(whole, &y)?;
    let columns = &whole.up_to(kept);
    y.truncate(kept);
    let all_steps: Vec<Vec<f64>> = pair.step_columns(axis).collect();
    let stds: Vec<f64> = pair.steps[axis].iter().map(|(_, std)| *std).collect();
    let fitted = determined(columns, &all_steps, &stds, &plain_noise.errors(&columns.cosine)?)?;
    let step_transforms: Vec<Vec<f64>> =
        fitted.iter().map(|step| columns.transform(&all_steps[*step])).collect();
    let followed: Vec<&[f64]> =
        follows.iter().flat_map(|follows| &follows.columns).map(Vec::as_slice).collect();
    let own: Vec<Vec<f64>> =
        followed.iter().map(|column| columns.transform(column)).chain(step_transforms).collect();
    let own = drift::Beside { own: &own, lines_hz: &seen };
    let (straight, noise) = columns.straight(&y, &own)?;
    let joint = drift::joint(columns, &y, &noise, &own)?;
    let demanded = joint.as_ref().filter(|joint| joint.p < drift::LEVEL);
    let drift_columns = demanded.map_or(Vec::new(), |joint| columns.exponential(joint.ln_tau).to_vec());
    let regression = demanded.map_or(&straight, |joint| &joint.regression);
    let mut noise = demanded.map_or(&noise, |joint| &joint.noise).clone();
    let [drifting, stepping] = [&drift_columns, &all_steps].map(|of| of.iter().map(Vec::as_slice).collect());
    let every: Vec<&[f64]> = [base, drifting, followed.clone(), stepping].concat();
    // Of the steps only those that are fitted have a place.
    let before_own = STRAIGHT + drift_columns.len();
    let mut places: Vec<Place> = (0..before_own + followed.len()).map(Place::Fitted).collect();
    places.extend(stds.iter().enumerate().map(|(number, std)| {
        let place = fitted.iter().position(|known| *known == number);
        place.map_or(Place::Held(*std), |place| Place::Fitted(before_own + followed.len() + place))
    }));
    let sizes: Vec<f64> =
        places[before_own..].iter().map(|place| place.of(&regression.coefficients)).collect();
    let level = without(test, &every[before_own..], &sizes);
    let source = source(whole, &level, &plain_noise.errors(&whole.cosine)?)?;
    let weighed = drift::weighed(pair, test, &every[STRAIGHT..])?;
    let mut found = drift::describe(columns, &level, regression, &noise, (joint.as_ref(), weighed))?;
    let matrix = &regression.coefficients[..DAYS];
    found.windows = drift::window_means(
        &rest(&pair.reference, &level, matrix),
        whole,
        &noise.errors(&whole.cosine)?,
        regression.covariance.as_ref().submatrix(0, 0, DAYS, DAYS),
    );
    // Of a month of seconds each of these columns is 20 MB.
    drop((straight, joint));
    // What follows a column needs no drift that the readings do not demand beside it: the two are much alike.
    let drifts = follows.is_empty() || found.demanded != DriftForm::None;
    let exponential: Vec<Vec<f64>> = drift_columns.iter().map(|column| columns.transform(column)).collect();
    let exponential: Vec<&[f64]> = exponential.iter().map(Vec::as_slice).collect();
    let mut all = columns.with(&exponential, &own);
    if !drifts {
        all.remove(DAYS);
        places = places.iter().map(|place| place.without(DAYS)).collect();
    }
    let errors = noise.errors(&columns.cosine)?;
    let mut fit = with_held(cosine::regress(&all, &y, &errors)?, &places);
    let mut difference = rest(&every, test, &fit.weighted);
    let mut freedom = [f64::INFINITY; 3];
    let whitened = if worse_than_levels(&difference, pair, axis) {
        let independent = Errors::independent(&columns.cosine);
        let least = cosine::weighted(&all, &y, &independent)?;
        noise = columns.noise(&least, &independent, &seen)?;
        let errors = noise.errors(&columns.cosine)?;
        let weights: Vec<Vec<f64>> = (0..all.len()).map(|i| least.weights(&all, &independent, i)).collect();
        let mut found = cosine::regress(&all, &y, &errors)?;
        found.weighted_covariance =
            Mat::from_fn(all.len(), all.len(), |i, j| errors.covariance_of(&weights[i], &weights[j]));
        found.weighted = least.coefficients;
        fit = with_held(found, &places);
        difference = rest(&every, test, &fit.weighted);
        Whitened {
            weights: std::array::from_fn(|i| errors.whiten(&errors.times(&weights[i]))),
            left: errors.whiten(&least.residual),
        }
    } else {
        let last = cosine::weighted(&all, &y, &errors)?;
        freedom = std::array::from_fn(|i| noise.freedom(&columns.cosine, &last.influence[i]));
        Whitened {
            weights: std::array::from_fn(|i| last.weights(&all, &errors, i)),
            left: errors.whiten(&last.residual),
        }
    };
    let offset_nt = mean(&without(test, &all_steps, &fit.weighted[every.len() - all_steps.len()..]))
        - (0..3).map(|i| fit.weighted[i] * mean(&pair.reference[i])).sum::<f64>();
    // Noise is told of all that is left, by its form: levels of octaves would hide what is not noise from the
    // tests that follow. It weighs only in the band.
    let noise = if kept == whole.kept {
        noise.form()
    } else {
        Noise::seen(&difference, pair)?.up_to(whole.cosine.frequency(kept))
    };
    let wider = whitened.wider();
    let fit = AxisFit {
        fit,
        noise,
        difference,
        offset_nt,
        drift: found,
        follows: follows.to_vec(),
        drift_columns,
        freedom,
        wider,
        across: Default::default(),
        source,
    };
    Ok((fit, whitened))
}

/// Whether a fit leaves more than levels alone would: weights rest on the periods at which the difference is
/// quiet, and where the noise is not of the form that is fitted, or the instruments share little, the matrix
/// by them may leave more than none does. Least squares cannot.
fn worse_than_levels(left: &[f64], pair: &Pair, axis: usize) -> bool {
    let levels = centred(&beside(pair, axis));
    dot(left, left) > dot(&levels, &levels)
}

/// Least squares of the reference's axes alone, with the covariance under these errors and by Newey and West.
fn source(columns: &Columns<'_>, test: &[f64], errors: &Errors) -> Result<Source, Error> {
    let reference = &columns.pair.reference;
    let fit = cosine::regress(&columns.base()[..3], &columns.transform(test), errors)?;
    let difference = rest(reference, test, &fit.least_squares);
    // Beside centred columns the constant stands alone.
    let count = test.len();
    let centred = reference.each_ref().map(|column| centred(column));
    let constant = vec![1.0; count];
    let [x, y, z] = centred.each_ref().map(Vec::as_slice);
    let inverse = Mat::from_fn(4, 4, |i, j| match (i, j) {
        (3, 3) => 1.0 / count as f64,
        (3, _) | (_, 3) => 0.0,
        _ => fit.independent[(i, j)],
    });
    let robust = hac::newey_west(&[x, y, z, &constant], &difference, inverse.as_ref(), hac::lags(count));
    Ok(Source { newey_west: (0..3).map(|i| robust[(i, i)].sqrt()).collect(), fit, difference })
}

/// Of what least squares leave the frequencies of its spectral lines (Hz), which are not noise, and its
/// noise.
fn plain(
    columns: &Columns<'_>,
    design: &[&[f64]],
    test: &[f64],
    y: &[f64],
) -> Result<(Vec<f64>, Noise), Error> {
    let independent = Errors::independent(&columns.cosine);
    let regression = cosine::weighted(&columns.base(), y, &independent)?;
    let left = rest(design, test, &regression.coefficients);
    let lines = periodogram(&left, columns.pair.step_s)?.lines;
    let lines_hz: Vec<f64> = lines.iter().map(|line| line.frequency_hz).collect();
    let noise = columns.noise(&regression, &independent, &lines_hz)?;
    Ok((lines_hz, noise))
}
