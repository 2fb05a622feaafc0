//! Columns that are one, and units that cannot be the same.

use common::{Axis, Error as Fault};

use crate::Error;

/// Two columns that are alike to this share of their changes are one.
const ALIKE: f64 = 1e-12;
/// The test instrument's changes over the reference's; beyond, they are in other units.
const UNITS: f64 = 20.0;

/// Refuses a test instrument, read from the recording at `path`, that is the reference or is in other units.
pub fn check(path: &str, reference: &[Vec<f64>; 3], test: &[Vec<f64>; 3]) -> Result<(), Error> {
    for (i, axis) in Axis::ALL.into_iter().enumerate() {
        for (j, other) in Axis::ALL.into_iter().enumerate() {
            let difference: Vec<f64> = reference[i].iter().zip(&test[j]).map(|(r, t)| t - r).collect();
            if spread(&difference) <= ALIKE * spread(&reference[i]) {
                let found = format!("the same readings as in `reference_{axis}_nt`");
                let expected = "readings of a second instrument; was a column copied?";
                return Err(
                    Fault::document(format!("{path}.columns.test_{other}_nt"), found, expected).into()
                );
            }
        }
    }
    let size =
        |columns: &[Vec<f64>; 3]| columns.iter().map(|column| spread(column).powi(2)).sum::<f64>().sqrt();
    let ratio = size(test) / size(reference);
    if !(1.0 / UNITS..=UNITS).contains(&ratio) {
        let found = format!("changes {ratio:.2e} times those of the reference");
        let expected = "readings of both instruments in nT; are those of one in V, or in µT?";
        return Err(Fault::document(format!("{path}.columns.test_x_nt"), found, expected).into());
    }
    Ok(())
}

/// Root of the mean square about the mean, over what is known.
fn spread(column: &[f64]) -> f64 {
    let known: Vec<f64> = column.iter().copied().filter(|value| value.is_finite()).collect();
    let mean = known.iter().sum::<f64>() / known.len() as f64;
    (known.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / known.len() as f64).sqrt()
}
