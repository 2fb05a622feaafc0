//! η and d, with the source's intervals and with ones that hold for errors with memory.

use common::{
    Axis, DifferentialCalibration, DifferentialFit, Drift, DriftForm, EventInstrument, KeptOut, KeptOutEvent,
    MatrixElement, PerAxis, Quantity,
};
use estimate::cosine::{self, Errors, Projection};
use estimate::periodogram::periodogram;
use estimate::spectral::SpectralFit;
use estimate::{hac, stats};
use faer::Mat;

use crate::across::{self, Whitened};
use crate::difference::{self, Noise};
use crate::drift::{self, Columns};
use crate::events::{Events, Found};
use crate::followed::{self, Candidate, Follows};
use crate::housekeeping::Housekeeping;
use crate::prepare::Prepared;
use crate::series::Pair;
use crate::{Error, alike, contributions, words};

/// The straight drift stands after the reference's axes, what else there is after it.
const DAYS: usize = 3;
const STRAIGHT: usize = DAYS + 1;
/// A column of which the others leave less than this share says nothing of its own.
const LEAST_OWN: f64 = 1e-6;

/// The fit of one axis of the test instrument.
pub struct AxisFit {
    /// Weighted coefficients of the reference's x, y, z (nT/nT), of the straight drift (nT/day), where an exponential drift is
    /// demanded of e^(−t/τ) (nT) and of its derivative with respect to ln τ, of the housekeeping columns that it follows, and of the steps (nT).
    pub fit: SpectralFit,
    /// Noise of the difference.
    pub noise: Noise,
    /// T − R η − drift − steps less its mean, η as weighted, nT.
    pub difference: Vec<f64>,
    /// Mean of T − R η, nT.
    pub offset_nt: f64,
    /// Its drift, as a document has it.
    pub drift: Drift,
    /// The housekeeping columns that it follows.
    pub follows: Vec<Follows>,
    /// e^(−t/τ) and its derivative with respect to ln τ, where that drift is demanded.
    drift_columns: Vec<Vec<f64>>,
    whitened: Whitened,
    source: Source,
}

impl AxisFit {
    /// The columns between the straight drift and the steps.
    fn further(&self) -> impl Iterator<Item = &Vec<f64>> {
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
        let days = drift::days(pair);
        let further: Vec<Vec<f64>> = self.further().cloned().collect();
        let design = [&pair.reference[..], std::slice::from_ref(&days), &further].concat();
        let steps: Vec<Vec<f64>> = pair.step_columns(axis).collect();
        let sizes = &self.fit.weighted[design.len()..];
        rest(&design, &without(&pair.test[axis], &steps, sizes), &self.fit.weighted)
    }
}

/// The source's fit: least squares of the reference's axes alone.
struct Source {
    fit: SpectralFit,
    newey_west: Vec<f64>,
    /// T − R η less its mean, nT.
    difference: Vec<f64>,
}

/// Fits each axis of the test instrument, beside the housekeeping columns that it follows.
pub fn fit(pair: &Pair, housekeeping: &[Housekeeping]) -> Result<[AxisFit; 3], Error> {
    let columns = Columns::of(pair);
    let candidates = followed::candidates(&columns, housekeeping);
    let one = |axis: usize, established: &[String]| one(&columns, &candidates, established, axis);
    let (x, (y, z)) = rayon::join(|| one(0, &[]), || rayon::join(|| one(1, &[]), || one(2, &[])));
    let mut fits = [x?, y?, z?];
    let mut established: Vec<String> =
        fits.iter().flat_map(|fit| fit.follows.iter().map(|follows| follows.name.clone())).collect();
    established.dedup();
    if !established.is_empty() {
        for (axis, fit) in fits.iter_mut().enumerate().filter(|(_, fit)| fit.follows.is_empty()) {
            *fit = one(axis, &established)?;
        }
    }
    Ok(fits)
}

/// The pair without steps, exponential drift and what follows housekeeping columns, as they were fitted.
pub fn level(pair: &Pair, fits: &[AxisFit; 3]) -> Pair {
    let columns = |axis: usize| -> Vec<Vec<f64>> {
        let further = fits[axis].further().cloned();
        further.chain(pair.step_columns(axis)).collect()
    };
    let test = std::array::from_fn(|axis| {
        without(&pair.test[axis], &columns(axis), &fits[axis].fit.weighted[STRAIGHT..])
    });
    Pair { test, steps: Default::default(), step_stds: Default::default(), ..pair.clone() }
}

/// The pair less what the exponential drifts that the readings demand explain of every column: no matrix rests on them then. They were
/// found with a matrix that noise of the reference pulls, and may be field that it left.
pub fn without_exponentials(pair: &Pair, fits: &[AxisFit; 3]) -> Pair {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in fits.iter().flat_map(|fit| &fit.drift_columns) {
        let middle = mean(column);
        let mut own: Vec<f64> = column.iter().map(|value| value - middle).collect();
        let length = cosine::dot(&own, &own).sqrt();
        // Twice, for what rounding leaves the first time.
        (0..2).for_each(|_| basis.iter().for_each(|known| take_off(&mut own, known)));
        let left = cosine::dot(&own, &own).sqrt();
        if left > LEAST_OWN * length {
            own.iter_mut().for_each(|value| *value /= left);
            basis.push(own);
        }
    }
    let mut pair = pair.clone();
    let columns = pair.reference.iter_mut().chain(&mut pair.test).chain(pair.third.iter_mut().flatten());
    for column in columns {
        // The constant is large: rounding.
        let middle = mean(column);
        column.iter_mut().for_each(|value| *value -= middle);
        basis.iter().for_each(|known| take_off(column, known));
        column.iter_mut().for_each(|value| *value += middle);
    }
    pair
}

/// Less its part along a column of length one.
fn take_off(values: &mut [f64], column: &[f64]) {
    let size = cosine::dot(values, column);
    values.iter_mut().zip(column).for_each(|(value, known)| *value -= size * known);
}

/// The matrix and the difference, as a document has them.
pub fn calibrate(
    raw: &Pair,
    prepared: &Prepared,
    fits: &[AxisFit; 3],
) -> Result<DifferentialCalibration, Error> {
    let pair = &prepared.pair;
    let rows = pair.whole.len();
    let mut fit = DifferentialFit {
        recordings: pair.recordings.clone(),
        samples: pair.samples(),
        step_s: pair.step_s,
        missing: rows - pair.samples(),
        quoted: words::quoted(),
        ..DifferentialFit::default()
    };
    let mut matrix = [[0.0; 3]; 3];
    let mut covariance = vec![vec![0.0; 9]; 9];
    let mut offsets = PerAxis::default();
    for (axis, found) in Axis::ALL.into_iter().zip(fits) {
        let j = axis.index();
        let source = &found.source;
        let mut described = difference::describe(&found.difference, &source.difference, &found.noise)?;
        described.drift = found.drift.clone();
        described.follows =
            found.followed().into_iter().map(|(follows, sizes)| follows.document(&sizes)).collect();
        described.weighted_up_to_hz = Some(found.noise.highest_hz()).filter(|highest| highest.is_finite());
        let variance = described.rms_nt.powi(2);
        for (i, reference) in Axis::ALL.into_iter().enumerate() {
            matrix[i][j] = found.fit.weighted[i];
            for k in 0..3 {
                covariance[3 * j + i][3 * j + k] = found.fit.weighted_covariance[(i, k)];
            }
            for (m, other) in fits.iter().enumerate().filter(|(m, _)| *m != j) {
                covariance[3 * j + i][3 * m..3 * m + 3]
                    .copy_from_slice(&across::covariance(&found.whitened, &other.whitened)[i]);
            }
            let element = MatrixElement {
                least_squares: source.fit.least_squares[i],
                std_independent: (source.fit.independent[(i, i)] * variance).sqrt(),
                std_newey_west: Some(source.newey_west[i]),
                std_noise: source.fit.covariance[(i, i)].sqrt(),
                weighted: found.fit.weighted[i],
                weighted_std: found.fit.weighted_covariance[(i, i)].sqrt(),
            };
            fit.elements.insert(format!("{reference}{axis}"), element);
        }
        // The mean of the noise is what is lowest in its spectrum: that of one over the length.
        let lowest = found.noise.density(1.0 / (rows as f64 * pair.step_s)) / (rows as f64 * pair.step_s);
        *offsets.entry(axis) = Some(Quantity::new(found.offset_nt, lowest.sqrt()));
        *fit.axes.entry(axis) = Some(described);
    }
    fit.kept_out = kept_out(raw, prepared, fits);
    fit.clock = prepared.clock.clone();
    let followed = fits.each_ref().map(|found| found.follows.as_slice());
    contributions::add(raw, prepared, followed, &mut fit)?;
    fit.answer = words::answer(&fit);
    fit.findings = words::findings(&fit, &fits.each_ref().map(|found| found.whitened.wider()));
    fit.findings.extend(words::unconfirmed(prepared.events.unconfirmed));
    fit.findings.extend(pair.told.iter().cloned());
    fit.findings.extend(pair.third.iter().map(|_| words::third()));
    let order = Axis::ALL.iter().flat_map(|j| (0..3).map(move |i| format!("matrix[{i}][{}]", j.index())));
    Ok(DifferentialCalibration {
        matrix: Some(matrix),
        offset_nt: Some(offsets),
        covariance: Some(covariance),
        covariance_order: Some(order.collect()),
        fit: Some(Box::new(fit)),
        ..DifferentialCalibration::default()
    })
}

/// Of each event, if it is a step, the size (nT) that the fit of its axes gives it: of the reference −η times its own is in each.
pub fn step_sizes(events: &Events, fits: &[AxisFit; 3]) -> Vec<Option<Quantity>> {
    let steps: [usize; 3] = std::array::from_fn(|axis| {
        events.places().iter().filter_map(|places| places[axis]).max().map_or(0, |last| last + 1)
    });
    let size = |(event, places): (&Found, [Option<usize>; 3])| {
        let (mut above, mut below) = (0.0, 0.0);
        for (axis, place) in places.into_iter().enumerate() {
            let (Some(place), fit) = (place, &fits[axis].fit) else { continue };
            let part = match event.instrument {
                EventInstrument::Reference => -fit.weighted[event.axis],
                _ => 1.0,
            };
            let column = fit.weighted.len() - steps[axis] + place;
            let variance = fit.weighted_covariance[(column, column)];
            above += part * fit.weighted[column] / variance;
            below += part * part / variance;
        }
        (below > 0.0).then(|| Quantity::new(event.size + above / below, below.sqrt().recip()))
    };
    events.found.iter().zip(events.places()).map(size).collect()
}

/// What was kept out, steps with their sizes under the fit.
fn kept_out(raw: &Pair, prepared: &Prepared, fits: &[AxisFit; 3]) -> KeptOut {
    let sizes = step_sizes(&prepared.events, fits);
    let events = prepared.events.found.iter().zip(sizes).map(|(event, size)| {
        let size_nt = size.unwrap_or_else(|| Quantity::new(event.size, event.std));
        KeptOutEvent {
            kind: event.kind,
            instrument: event.instrument,
            axis: Axis::ALL[event.axis],
            time_s: raw.time_s(event.from),
            rows: [event.from, event.to],
            size_nt,
            z: event.z,
            extra: common::Extra::new(),
        }
    });
    KeptOut {
        events: events.collect(),
        gaps: raw.gaps(),
        more: prepared.events.more,
        extra: common::Extra::new(),
    }
}

/// One axis: the reference's three axes, the drift that the readings demand and the steps, under the noise of what they leave, in
/// the band in which the instruments answer alike.
fn one(
    whole: &Columns<'_>,
    candidates: &[Candidate],
    established: &[String],
    axis: usize,
) -> Result<AxisFit, Error> {
    let pair = whole.pair;
    let test = &pair.test[axis];
    let mut y = whole.transform(test);
    let base_design = [&pair.reference[..], std::slice::from_ref(&whole.days)].concat();
    let seen = lines(whole, &base_design, test, &y)?;
    let plain_noise = plain_noise(whole, &y, &seen)?;
    let kept = alike::band(whole, &y)?;
    let columns = &whole.up_to(kept);
    y.truncate(kept);
    let all_steps: Vec<Vec<f64>> = pair.step_columns(axis).collect();
    let fitted =
        determined(columns, &all_steps, &pair.step_stds[axis], &plain_noise.errors(&columns.cosine)?)?;
    let steps: Vec<Vec<f64>> = fitted.iter().map(|step| all_steps[*step].clone()).collect();
    let step_transforms: Vec<Vec<f64>> = steps.iter().map(|step| columns.transform(step)).collect();
    let beside = drift::Beside { own: &step_transforms, lines_hz: &seen };
    let follows = followed::follows(columns, &y, candidates, established, &beside)?;
    let followed: Vec<Vec<f64>> = follows.iter().flat_map(|follows| follows.columns.clone()).collect();
    let own: Vec<Vec<f64>> =
        followed.iter().map(|column| columns.transform(column)).chain(step_transforms).collect();
    let beside = drift::Beside { own: &own, lines_hz: &seen };
    let (mut straight, mut noise) = columns.straight(&y, &beside)?;
    let explanations = drift::explained(columns, &straight);
    if let Some(found) = explanations.as_ref().filter(|found| found.is_drift()) {
        noise = noise.with_lowest(&columns.cosine, &found.beside_drift);
        straight = columns.under(&y, &noise, &beside)?;
    }
    let joint = drift::joint(columns, &y, &noise, &beside)?;
    let demanded = joint.as_ref().filter(|joint| joint.p < drift::LEVEL);
    let drift_columns = demanded.map_or(Vec::new(), |joint| columns.exponential(joint.ln_tau).to_vec());
    let regression = demanded.map_or(&straight, |joint| &joint.regression);
    let mut noise = demanded.map_or(&noise, |joint| &joint.noise).clone();
    let design = [&base_design[..], &drift_columns, &followed, &steps].concat();
    let of_own = &regression.coefficients[design.len() - own.len()..];
    let level = without(test, &[&followed[..], &steps].concat(), of_own);
    let mut found = drift::describe(columns, &level, regression, &noise, joint.as_ref())?;
    if let Some(explanations) = &explanations {
        let (value, std) =
            (found.straight_nt_per_day.value(), found.straight_nt_per_day.std().unwrap_or(0.0));
        if explanations.is_drift() {
            let marginal = explanations.straight_nt_per_day.std().unwrap_or(0.0);
            found.straight_nt_per_day = Quantity::new(value, std.max(marginal));
        }
        found.explanations = Some(explanations.document());
    }
    let matrix = &regression.coefficients[..DAYS];
    found.windows = drift::window_means(&rest(&pair.reference, &level, matrix), pair);
    // What follows a column needs no drift that the readings do not demand beside it: the two are much alike.
    let drifts = follows.is_empty() || found.demanded != DriftForm::None;
    let fitted_columns: Vec<usize> = (0..design.len()).filter(|column| drifts || *column != DAYS).collect();
    let all: Vec<Vec<f64>> =
        fitted_columns.iter().map(|column| columns.transform(&design[*column])).collect();
    let all: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
    let errors = noise.errors(&columns.cosine)?;
    let last = cosine::weighted(&all, &y, &errors)?;
    let mut places: Vec<Place> = (0..design.len() - steps.len())
        .map(|column| {
            fitted_columns.iter().position(|own| *own == column).map_or(Place::Held(0.0), Place::Fitted)
        })
        .collect();
    places.extend(pair.step_stds[axis].iter().enumerate().map(|(number, std)| {
        let place = fitted.iter().position(|known| *known == number);
        place.map_or(Place::Held(*std), |place| Place::Fitted(all.len() - steps.len() + place))
    }));
    let mut fit = with_held(cosine::regress(&all, &y, &errors)?, &places);
    let every = [&base_design[..], &drift_columns, &followed, &all_steps].concat();
    let mut difference = rest(&every, test, &fit.weighted);
    if worse_than_levels(&difference, pair, axis) {
        difference = rest(&every, test, &fit.least_squares);
        noise = Noise::seen(&difference, pair)?;
        fit = with_held(cosine::regress(&all, &y, &noise.errors(&columns.cosine)?)?, &places);
        (fit.weighted, fit.weighted_covariance) = (fit.least_squares.clone(), fit.covariance.clone());
    }
    let whitened = Whitened {
        weights: std::array::from_fn(|i| last.weights[i].clone()),
        left: errors.whiten(&last.residual),
    };
    let offset_nt = mean(&without(test, &all_steps, &fit.weighted[every.len() - all_steps.len()..]))
        - (0..3).map(|i| fit.weighted[i] * mean(&pair.reference[i])).sum::<f64>();
    let source = source(whole, &level, &plain_noise.errors(&whole.cosine)?)?;
    // Noise is told of all that is left, by its form: levels of octaves would hide what is not noise from the tests that follow. It weighs only in the
    // band.
    let noise = if kept == whole.kept {
        noise.form()
    } else {
        Noise::seen(&difference, pair)?.up_to(whole.cosine.frequency(kept))
    };
    Ok(AxisFit { fit, noise, difference, offset_nt, drift: found, follows, drift_columns, whitened, source })
}

/// Whether a fit leaves more than levels alone would: weights rest on the periods at which the difference is quiet, and where the noise is not of
/// the form that is fitted, or the instruments share little, the matrix by them may leave more than none does. Least squares cannot.
fn worse_than_levels(left: &[f64], pair: &Pair, axis: usize) -> bool {
    let (test, reference) = (&pair.test[axis], &pair.reference[axis]);
    let apart: Vec<f64> = test.iter().zip(reference).map(|(test, reference)| test - reference).collect();
    let levels = rest::<Vec<f64>>(&[], &apart, &[]);
    cosine::dot(left, left) > cosine::dot(&levels, &levels)
}

/// The steps of which the band says more, beside the other columns and each other, than the search that found them: these are fitted, the
/// others keep the sizes that were found. So steps that lie too close for the band are not told apart by it.
fn determined(
    columns: &Columns<'_>,
    steps: &[Vec<f64>],
    stds: &[f64],
    errors: &Errors,
) -> Result<Vec<usize>, Error> {
    let transforms: Vec<Vec<f64>> = steps.iter().map(|step| columns.transform(step)).collect();
    let mut fitted: Vec<usize> = Vec::new();
    for (number, (transform, std)) in transforms.iter().zip(stds).enumerate() {
        let mut beside = columns.base();
        beside.extend(fitted.iter().map(|step| transforms[*step].as_slice()));
        let Some(direction) = Projection::of(&beside, transform, errors)?.direction(transform, errors) else {
            continue;
        };
        let information = cosine::dot(&direction, &errors.whiten(transform));
        if information * std >= 1.0 {
            fitted.push(number);
        }
    }
    Ok(fitted)
}

/// Where a column stands in a fit.
#[derive(Clone, Copy)]
enum Place {
    /// There.
    Fitted(usize),
    /// Nowhere: nothing is to be added to what was taken off, with this standard uncertainty.
    Held(f64),
}

/// A fit with the columns that were not fitted in their places.
fn with_held(fit: SpectralFit, places: &[Place]) -> SpectralFit {
    let value = |own: &[f64], place: &Place| match place {
        Place::Fitted(at) => own[*at],
        Place::Held(_) => 0.0,
    };
    let values = |own: &[f64]| -> Vec<f64> { places.iter().map(|place| value(own, place)).collect() };
    let matrix = |own: &Mat<f64>| {
        Mat::from_fn(places.len(), places.len(), |i, j| match (places[i], places[j]) {
            (Place::Fitted(a), Place::Fitted(b)) => own[(a, b)],
            (Place::Held(std), Place::Held(_)) if i == j => std * std,
            _ => 0.0,
        })
    };
    SpectralFit {
        least_squares: values(&fit.least_squares),
        covariance: matrix(&fit.covariance),
        independent: matrix(&fit.independent),
        weighted: values(&fit.weighted),
        weighted_covariance: matrix(&fit.weighted_covariance),
    }
}

/// Noise of what least squares leave.
fn plain_noise(columns: &Columns<'_>, y: &[f64], lines_hz: &[f64]) -> Result<Noise, Error> {
    let independent = Errors::independent(&columns.cosine);
    columns.noise(&cosine::weighted(&columns.base(), y, &independent)?, &independent, lines_hz)
}

/// Least squares of the reference's axes alone, with the covariance under these errors and by Newey and West.
fn source(columns: &Columns<'_>, test: &[f64], errors: &Errors) -> Result<Source, Error> {
    let reference = &columns.pair.reference;
    let fit = cosine::regress(&columns.base()[..3], &columns.transform(test), errors)?;
    let difference = rest(reference, test, &fit.least_squares);
    let means = reference.each_ref().map(|column| mean(column));
    // Beside centred columns the constant stands alone.
    let count = test.len();
    let design = Mat::from_fn(count, 4, |i, j| if j < 3 { reference[j][i] - means[j] } else { 1.0 });
    let inverse = Mat::from_fn(4, 4, |i, j| match (i, j) {
        (3, 3) => 1.0 / count as f64,
        (3, _) | (_, 3) => 0.0,
        _ => fit.independent[(i, j)],
    });
    let robust = hac::newey_west(design.as_ref(), &difference, inverse.as_ref(), hac::lags(count));
    Ok(Source { newey_west: (0..3).map(|i| robust[(i, i)].sqrt()).collect(), fit, difference })
}

/// The readings less steps of these sizes.
fn without(test: &[f64], steps: &[Vec<f64>], sizes: &[f64]) -> Vec<f64> {
    let row =
        |row: usize| test[row] - steps.iter().zip(sizes).map(|(step, size)| size * step[row]).sum::<f64>();
    (0..test.len()).map(row).collect()
}

/// Frequencies (Hz) at which what least squares leave has spectral lines: they are not noise.
fn lines(columns: &Columns<'_>, design: &[Vec<f64>], test: &[f64], y: &[f64]) -> Result<Vec<f64>, Error> {
    let plain = cosine::weighted(&columns.base(), y, &Errors::independent(&columns.cosine))?;
    let left = rest(design, test, &plain.coefficients);
    Ok(periodogram(&left, columns.pair.step_s)?.lines.iter().map(|line| line.frequency_hz).collect())
}

/// The mean, summed a second time about itself so that a large constant leaves no error of rounding.
pub fn mean(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let first = values.iter().sum::<f64>() / count;
    first + values.iter().map(|value| value - first).sum::<f64>() / count
}

/// What the columns leave, less its mean.
pub fn rest<C: AsRef<[f64]>>(columns: &[C], y: &[f64], coefficients: &[f64]) -> Vec<f64> {
    let middle = mean(y);
    let mut left: Vec<f64> = y.iter().map(|value| value - middle).collect();
    for (column, coefficient) in columns.iter().map(AsRef::as_ref).zip(coefficients) {
        let middle = mean(column);
        left.iter_mut().zip(column).for_each(|(left, value)| *left -= coefficient * (value - middle));
    }
    left
}

/// Probability of a quantity so far from zero by chance.
pub fn p_of(quantity: &Quantity) -> f64 {
    stats::two_sided_p(quantity.value() / quantity.std().unwrap_or(f64::INFINITY), f64::INFINITY)
}
