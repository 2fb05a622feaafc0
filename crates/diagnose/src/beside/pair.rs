//! Two magnetometers side by side.

use common::{Axis, Document};
use joined::Pair;

use super::declared::Declared;
use super::stated::less_effects;
use super::{Compared, coarse, frozen, rms};
use crate::Error;

/// Explains the difference of the instruments of a document's differential recordings.
pub fn compared(document: &Document, told: &dyn Fn(&str)) -> Result<Compared, Error> {
    let (frozen, document) = frozen::without(document);
    let document = &less_effects(&document)?;
    let read = joined::read(document)?;
    let covariates = joined::beside(document, &read.recordings);
    let of =
        paired::find(&read, super::asked(document, &read.recordings, &covariates), told)?.explained(told)?;
    let as_it_came = (0..3).map(|axis| rms(&stated(document, &read, axis, &of.rows))).collect();
    let channels = Axis::ALL.iter().map(|axis| (format!("test_{axis}_nt"), Some(*axis))).collect();
    let instruments = document.instrument.as_ref().zip(read.reference_noise.as_ref());
    let declared =
        instruments.and_then(|both| Declared::of(both, &of.problem.time_s, &of.explained.residual));
    Ok(Compared {
        declared,
        recordings: read.recordings.clone(),
        channels,
        what: "the test instrument",
        as_it_came,
        notes: read.told.into_iter().map(|told| told.words).collect(),
        coarse: coarse::widths(document),
        frozen,
        ..Compared::of(&covariates, of)
    })
}

/// The difference with the stated matrix and offsets; with equal axes and levels where none are stated.
fn stated(document: &Document, pair: &Pair, axis: usize, rows: &[usize]) -> Vec<f64> {
    let known = document.calibration.as_ref().and_then(|calibration| calibration.differential.as_ref());
    let matrix = known.and_then(|known| known.matrix);
    let offset =
        known.and_then(|known| known.offset_nt.as_ref()?.get(Axis::ALL[axis])).map(common::Quantity::value);
    let predicted = |row: usize| match &matrix {
        Some(matrix) => (0..3).map(|i| matrix[i][axis] * pair.reference[i][row]).sum(),
        None => pair.reference[axis][row],
    };
    let left: Vec<f64> = rows.iter().map(|row| pair.test[axis][*row] - predicted(*row)).collect();
    let level = offset.unwrap_or_else(|| estimate::stats::mean(&left));
    left.iter().map(|value| value - level).collect()
}
