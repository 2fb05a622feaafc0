//! Whether the matrix holds still: in time, between quiet and disturbed times, from short to long periods.

use std::ops::Range;

use common::MatrixStability;

use crate::regression::AxisFit;
use crate::series::Pair;
use crate::windows::Noise;
use crate::{Error, bands, windows};

/// All three; none of a recording that is too short to be divided.
pub fn of(pair: &Pair, fits: &[AxisFit; 3]) -> Result<Option<MatrixStability>, Error> {
    let Some(rows) = windows::divide(pair) else { return Ok(None) };
    match all(pair, fits, &rows) {
        Err(Error::Estimate(error)) => {
            let finding = format!("whether the matrix holds still cannot be said: {error}");
            Ok(Some(MatrixStability { findings: vec![finding], ..MatrixStability::default() }))
        }
        found => found.map(Some),
    }
}

fn all(pair: &Pair, fits: &[AxisFit; 3], rows: &[Range<usize>]) -> Result<MatrixStability, Error> {
    let noise = Noise::of(pair, fits, rows)?;
    let in_windows = windows::windows(pair, fits, &noise, rows)?;
    let quiet_disturbed = windows::quiet_disturbed(pair, fits, &noise)?;
    let in_bands = bands::bands(pair, fits, &noise)?;
    let mut findings = windows::findings(&in_windows);
    findings.extend(quiet_disturbed.iter().flat_map(windows::quiet_findings));
    findings.extend(bands::findings(&in_bands));
    Ok(MatrixStability { windows: Some(in_windows), quiet_disturbed, bands: Some(in_bands), findings })
}
