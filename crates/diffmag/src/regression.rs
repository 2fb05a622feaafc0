//! η and d, with the source's intervals and with ones that hold for errors with memory.

mod axis;
mod held;

pub use axis::AxisFit;
use axis::{STRAIGHT, one};

use common::{
    Axis, DifferentialCalibration, DifferentialFit, EventInstrument, KeptOut, KeptOutEvent, MatrixElement,
    PerAxis, Quantity,
};
use estimate::cosine;
use estimate::stats::mean;

use crate::across;
use crate::difference;
use crate::drift::Columns;
use crate::events::{Events, Found};
use crate::followed;
use crate::housekeeping::Housekeeping;
use crate::prepare::Prepared;
use crate::residual::{scatter, without};
use crate::series::Pair;
use crate::{Error, contributions, words};

/// A column of which the others leave less than this share says nothing of its own.
const LEAST_OWN: f64 = 1e-6;

/// Fits each axis of the test instrument, beside the housekeeping columns that it follows.
pub fn fit(pair: &Pair, housekeeping: &[Housekeeping]) -> Result<[AxisFit; 3], Error> {
    let columns = Columns::of(pair);
    let candidates = followed::candidates(&columns, housekeeping);
    let one = |axis: usize, established: &[String]| one(&columns, &candidates, established, axis);
    // One after the other: the columns of each are many times as large as the readings.
    let mut found = [one(0, &[])?, one(1, &[])?, one(2, &[])?];
    let mut established: Vec<String> =
        found.iter().flat_map(|(fit, _)| fit.follows.iter().map(|follows| follows.name.clone())).collect();
    established.dedup();
    if !established.is_empty() {
        for (axis, of) in found.iter_mut().enumerate().filter(|(_, (fit, _))| fit.follows.is_empty()) {
            *of = one(axis, &established)?;
        }
    }
    let across = |axis: usize, other: usize| match axis == other {
        true => Default::default(),
        false => across::covariance(&found[axis].1, &found[other].1),
    };
    let across: [_; 3] = std::array::from_fn(|axis| std::array::from_fn(|other| across(axis, other)));
    let mut fits = found.map(|(fit, _)| fit);
    fits.iter_mut().zip(across).for_each(|(fit, across)| fit.across = across);
    Ok(fits)
}

/// The pair without steps, exponential drift and what follows housekeeping columns, as they were fitted.
pub fn level(pair: &Pair, fits: &[AxisFit; 3]) -> Pair {
    let columns = |axis: usize| -> Vec<Vec<f64>> {
        let further = fits[axis].further().cloned();
        further.chain(pair.step_columns(axis)).collect()
    };
    let test = std::array::from_fn(|axis| {
        let sizes = &fits[axis].fit.weighted[STRAIGHT..];
        if sizes.is_empty() {
            return pair.test[axis].clone();
        }
        without(&pair.test[axis], &columns(axis), sizes).into()
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
        described.rms_left_nt = Some(scatter(&found.difference, &pair.whole));
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
            for (m, across) in found.across.iter().enumerate().filter(|(m, _)| *m != j) {
                covariance[3 * j + i][3 * m..3 * m + 3].copy_from_slice(&across[i]);
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
    fit.findings = words::findings(&fit, &fits.each_ref().map(|found| found.wider));
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
