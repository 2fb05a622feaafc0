//! Columns that are one, and units that cannot be the same.

use common::number::significant;
use common::{Axis, Column};
use estimate::tsqr::Tsqr;

use crate::{Error, Result};

/// Two columns that are alike to this share of their changes are one.
pub const ALIKE: f64 = 1e-12;
/// The test instrument's changes over the reference's; beyond, they are in other units.
const UNITS: f64 = 20.0;
/// A share of its changes: what a third axis must have beside the other two.
const OUT_OF_PLANE: f64 = 1e-7;
/// What is said where it has not.
pub const IN_A_PLANE: &str = "the reference's x, y and z depend on each other: the field changed in a plane only, which leaves the matrix \
                              open across it; record longer, or while the field changes more";

/// Refuses a test instrument that is the reference or is in other units, and instruments of which two axes
/// are one. `paths` are those of their first recordings.
pub fn check(paths: [&String; 2], reference: &[Column; 3], test: &[Column; 3]) -> Result<()> {
    for (path, instrument, columns) in [(paths[0], "reference", reference), (paths[1], "test", test)] {
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let difference: Vec<f64> = columns[i].iter().zip(&columns[j]).map(|(a, b)| b - a).collect();
            if spread(&difference) <= ALIKE * spread(&columns[i]) {
                let [axis, other] = [i, j].map(|axis| Axis::ALL[axis]);
                let found = format!("the same readings as in `{instrument}_{axis}_nt`");
                let expected = "readings along another axis; was a column copied?";
                let at = format!("{path}.columns.{instrument}_{other}_nt");
                return Err(Error::document(at, found, expected));
            }
        }
    }
    let path = paths[1];
    for (i, axis) in Axis::ALL.into_iter().enumerate() {
        for (j, other) in Axis::ALL.into_iter().enumerate() {
            let difference: Vec<f64> = reference[i].iter().zip(&test[j]).map(|(r, t)| t - r).collect();
            if spread(&difference) <= ALIKE * spread(&reference[i]) {
                let found = format!("the same readings as in `reference_{axis}_nt`");
                let expected = "readings of a second instrument; was a column copied?";
                return Err(Error::document(format!("{path}.columns.test_{other}_nt"), found, expected));
            }
        }
    }
    let whole: Vec<usize> = (0..reference[0].len())
        .filter(|row| reference.iter().all(|column| column[*row].is_finite()))
        .collect();
    let columns =
        reference.each_ref().map(|column| whole.iter().map(|row| column[*row]).collect::<Vec<f64>>());
    let mut factor = Tsqr::new(3);
    factor.push(&columns.each_ref().map(Vec::as_slice));
    if in_a_plane(&factor, [0, 1], 2)? {
        return Err(Error::Unanswerable(IN_A_PLANE.into()));
    }
    let size =
        |columns: &[Column; 3]| columns.iter().map(|column| spread(column).powi(2)).sum::<f64>().sqrt();
    let ratio = size(test) / size(reference);
    let Some((found, expected)) = other_units(ratio) else { return Ok(()) };
    Err(Error::document(format!("{path}.columns.test_x_nt"), found, expected))
}

/// What is found and what is expected where the test instrument's changes are so many times the reference's.
pub fn other_units(ratio: f64) -> Option<(String, &'static str)> {
    let found = || format!("changes {} times those of the reference", significant(ratio, 3));
    let expected = "readings of both instruments in nT; are those of one in V, or in µT?";
    (!(1.0 / UNITS..=UNITS).contains(&ratio)).then(|| (found(), expected))
}

/// Whether a column follows from two others.
pub fn in_a_plane(factor: &Tsqr, two: [usize; 2], third: usize) -> Result<bool, estimate::Error> {
    match factor.regress(&two, &[third]) {
        Ok(left) => {
            let all = factor.regress(&[], &[third])?;
            Ok(left.squares[0].sqrt() <= OUT_OF_PLANE * all.squares[0].sqrt())
        }
        Err(estimate::Error::Decomposition { .. }) => Ok(true),
        Err(other) => Err(other),
    }
}

/// Root of the mean square about the mean, over what is known.
fn spread(column: &[f64]) -> f64 {
    let known: Vec<f64> = column.iter().copied().filter(|value| value.is_finite()).collect();
    let mean = known.iter().sum::<f64>() / known.len() as f64;
    (known.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / known.len() as f64).sqrt()
}
