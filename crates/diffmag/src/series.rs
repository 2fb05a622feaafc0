//! The two instruments' readings as even series, with what is wrong told by its place.

use common::{Axis, Document, Error as Fault, Recording, procedure, series};
use physics::memory::bridged;

use crate::Error;

/// Fewer samples than these say nothing.
const LEAST: usize = 5;
/// Two columns that are alike to this share of their changes are one.
const ALIKE: f64 = 1e-12;
/// The test instrument's changes over the reference's; beyond, they are in other units.
const UNITS: f64 = 20.0;

/// Both instruments at the same moments.
pub struct Pair<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// From one sample to the next, s.
    pub step_s: f64,
    /// Readings of the reference, missing ones bridged, nT.
    pub reference: [Vec<f64>; 3],
    /// Readings of the test instrument, missing ones bridged, nT.
    pub test: [Vec<f64>; 3],
    /// Rows in which nothing is missing.
    pub whole: Vec<bool>,
}

impl Pair<'_> {
    /// How many samples are whole.
    pub fn samples(&self) -> usize {
        self.whole.iter().filter(|whole| **whole).count()
    }
}

/// Reads the one differential recording of a document.
pub fn read(document: &Document) -> Result<Pair<'_>, Error> {
    let mut found =
        document.recordings.iter().enumerate().filter(|(_, r)| r.procedure == procedure::DIFFERENTIAL);
    let (index, recording) = found.next().ok_or(Error::Nothing)?;
    if let Some((second, _)) = found.next() {
        let expected = "one differential recording in a document";
        return Err(Fault::document(format!("recordings[{second}]"), "a second one", expected).into());
    }
    let path = format!("recordings[{index}]");
    if recording.table.is_some() {
        let expected = "the readings under `columns`";
        return Err(Fault::document(format!("{path}.table"), "a file beside the document", expected).into());
    }
    let rows = recording.rows();
    if rows < LEAST {
        let found = format!("{rows} rows");
        let expected = "at least five: a regression has four unknowns for each axis";
        return Err(Fault::document(format!("{path}.columns"), found, expected).into());
    }
    let time = recording.column("time_s").unwrap_or_default();
    let key = format!("{path}.columns.time_s");
    if let Some(row) = time.windows(2).position(|pair| pair[1] <= pair[0]) {
        let found = format!("{} after {} in row {}", time[row + 1], time[row], row + 1);
        return Err(
            Fault::document(key, found, "times that rise; sort the rows, and take doubles out").into()
        );
    }
    let Some(step_s) = series::even_step_s(time) else {
        let expected = "even times, with nulls in the readings where samples are missing";
        return Err(Fault::document(key, "no even times", expected).into());
    };
    let columns = |quantity: &str| -> Result<[Vec<f64>; 3], Error> {
        let mut all: [Vec<f64>; 3] = Default::default();
        for axis in Axis::ALL {
            all[axis.index()] = column(recording, &path, quantity, axis)?;
        }
        Ok(all)
    };
    let (reference, test) = (columns("reference")?, columns("test")?);
    let whole: Vec<bool> =
        (0..rows).map(|row| reference.iter().chain(&test).all(|c| c[row].is_finite())).collect();
    let together = whole.iter().filter(|whole| **whole).count();
    if together < LEAST {
        let found = format!("{together} rows in which both instruments read");
        let expected = "at least five: do the two recordings overlap in time?";
        return Err(Fault::document(format!("{path}.columns"), found, expected).into());
    }
    check(&path, &reference, &test)?;
    let bridge = |columns: [Vec<f64>; 3]| columns.map(|column| bridged(time, column));
    Ok(Pair { recording, step_s, reference: bridge(reference), test: bridge(test), whole })
}

fn column(recording: &Recording, path: &str, quantity: &str, axis: Axis) -> Result<Vec<f64>, Error> {
    let name = format!("{quantity}_{axis}_nt");
    let Some(column) = recording.column(&name) else {
        let expected = format!("`{name}`, the readings of the {quantity} instrument along {axis}");
        return Err(Fault::document(format!("{path}.columns"), "no such column", expected).into());
    };
    let known: Vec<f64> = column.iter().copied().filter(|value| value.is_finite()).collect();
    if known.len() < LEAST {
        let found = format!("{} readings", known.len());
        return Err(Fault::document(format!("{path}.columns.{name}"), found, "at least five").into());
    }
    if known.iter().all(|value| *value == known[0]) {
        let found = format!("the constant reading {}", known[0]);
        let expected = "readings that follow the field; was the instrument connected?";
        return Err(Fault::document(format!("{path}.columns.{name}"), found, expected).into());
    }
    Ok(column.to_vec())
}

/// Root of the mean square about the mean, over what is known.
fn spread(column: &[f64]) -> f64 {
    let known: Vec<f64> = column.iter().copied().filter(|value| value.is_finite()).collect();
    let mean = known.iter().sum::<f64>() / known.len() as f64;
    (known.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / known.len() as f64).sqrt()
}

/// Columns that are one, and units that cannot be the same.
fn check(path: &str, reference: &[Vec<f64>; 3], test: &[Vec<f64>; 3]) -> Result<(), Error> {
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
