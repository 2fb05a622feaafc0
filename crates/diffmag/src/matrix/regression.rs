//! η and d, with the source's intervals and with ones that hold for errors with memory.

mod axis;
mod held;

pub use axis::AxisFit;
use axis::{STRAIGHT, one};

use common::{EventInstrument, Quantity};
use estimate::dot;
use estimate::stats::mean;

use crate::Error;
use crate::across;
use crate::drift::Columns;
use joined::Pair;
use paired::events::{Events, FoundEvent};
use paired::followed::Follows;
use paired::residual::without;

/// A column of which the others leave less than this share says nothing of its own.
const LEAST_OWN: f64 = 1e-6;

/// Fits each axis of the test instrument, beside the columns that it follows.
pub fn fit(pair: &Pair, follows: &[Follows]) -> Result<[AxisFit; 3], Error> {
    let columns = Columns::of(pair);
    // One after the other: the columns of each are many times as large as the readings.
    let found = [one(&columns, follows, 0)?, one(&columns, follows, 1)?, one(&columns, follows, 2)?];
    let across = |axis: usize, other: usize| {
        if axis != other {
            return across::covariance(&found[axis].1, &found[other].1);
        }
        let own = &found[axis].0.fit.weighted_covariance;
        std::array::from_fn(|i| std::array::from_fn(|k| own[(i, k)]))
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
    let of_axis = |axis: usize| {
        let sizes = &fits[axis].fit.weighted[STRAIGHT..];
        if sizes.is_empty() {
            return pair.test[axis].clone();
        }
        without(&pair.test[axis], &columns(axis), sizes).into()
    };
    Pair { test: (0..fits.len()).map(of_axis).collect(), steps: vec![Vec::new(); fits.len()], ..pair.clone() }
}

/// The pair less what the exponential drifts that the readings demand explain of every column: no matrix
/// rests on them then. They were found with a matrix that noise of the reference pulls, and may be field that
/// it left.
pub fn without_exponentials(pair: &Pair, fits: &[AxisFit; 3]) -> Pair {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in fits.iter().flat_map(|fit| &fit.drift_columns) {
        let middle = mean(column);
        let mut own: Vec<f64> = column.iter().map(|value| value - middle).collect();
        let length = dot(&own, &own).sqrt();
        // Twice, for what rounding leaves the first time.
        (0..2).for_each(|_| basis.iter().for_each(|known| take_off(&mut own, known)));
        let left = dot(&own, &own).sqrt();
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
    let size = dot(values, column);
    values.iter_mut().zip(column).for_each(|(value, known)| *value -= size * known);
}

/// Of each event, if it is a step, the size (nT) that the fit of its axes gives it: of the reference −η times
/// its own is in each.
pub fn step_sizes(events: &Events, fits: &[AxisFit; 3]) -> Vec<Option<Quantity>> {
    let steps: [usize; 3] = std::array::from_fn(|axis| {
        events.places(fits.len()).iter().filter_map(|places| places[axis]).max().map_or(0, |last| last + 1)
    });
    let size = |(event, places): (&FoundEvent, Vec<Option<usize>>)| {
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
    events.found.iter().zip(events.places(fits.len())).map(size).collect()
}
