//! What columns leave of readings.

use estimate::stats::{mean, rms};
use joined::Pair;

/// The readings less steps of these sizes.
pub fn without<C: AsRef<[f64]>>(test: &[f64], steps: &[C], sizes: &[f64]) -> Vec<f64> {
    let mut left = test.to_vec();
    for (step, size) in steps.iter().map(AsRef::as_ref).zip(sizes).filter(|(_, size)| **size != 0.0) {
        left.iter_mut().zip(step).for_each(|(left, value)| *left -= size * value);
    }
    left
}

/// The values less their mean.
pub fn centred(values: &[f64]) -> Vec<f64> {
    let middle = mean(values);
    values.iter().map(|value| value - middle).collect()
}

/// What the columns leave, less its mean. They are taken one after the other: those that are made on the way
/// need not be there together.
pub fn rest<C: AsRef<[f64]>>(
    columns: impl IntoIterator<Item = C>,
    y: &[f64],
    coefficients: &[f64],
) -> Vec<f64> {
    let mut left = centred(y);
    for (column, coefficient) in columns.into_iter().zip(coefficients) {
        let column = column.as_ref();
        let middle = mean(column);
        left.iter_mut().zip(column).for_each(|(left, value)| *left -= coefficient * (value - middle));
    }
    left
}

/// Standard deviation of the rows that are whole.
pub fn scatter(values: &[f64], rows: &[bool]) -> f64 {
    let used: Vec<f64> = values.iter().zip(rows).filter(|(_, row)| **row).map(|(value, _)| *value).collect();
    rms(&centred(&used))
}

/// What an axis of the test instrument reads beside that of the reference of the same name, nT.
pub fn beside(pair: &Pair, axis: usize) -> Vec<f64> {
    pair.test[axis].iter().zip(&pair.reference[axis]).map(|(test, reference)| test - reference).collect()
}

/// What is left of an axis without any fit but that of a level: the test instrument less the reference, nT
/// rms.
pub fn of_levels(pair: &Pair, axis: usize) -> f64 {
    scatter(&beside(pair, axis), &pair.whole)
}
