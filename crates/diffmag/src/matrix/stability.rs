//! Whether the matrix holds still: in time, between quiet and disturbed times, from short to long periods.

use common::{Code, Findings, MatrixStability};

use crate::regression::AxisFit;
use crate::windows::Noise;
use crate::{Error, bands, windows};
use joined::Pair;

/// All three; none of a recording that is too short to be divided. What one of them cannot say is no reason
/// for the others to be silent.
pub fn of(pair: &Pair, fits: &[AxisFit; 3]) -> Result<Option<MatrixStability>, Error> {
    let Some(rows) = windows::divide(pair) else { return Ok(None) };
    let mut found = MatrixStability::default();
    let noise = told(Noise::of(pair, fits, &rows), "whether the matrix is constant", &mut found.findings)?;
    let Some(noise) = noise else { return Ok(Some(found)) };
    let in_windows = windows::windows(pair, fits, &noise, &rows);
    found.windows = told(in_windows, "whether the matrix is constant in time", &mut found.findings)?;
    found.findings.extend(found.windows.iter().flat_map(windows::findings));
    let quiet_disturbed = windows::quiet_disturbed(pair, fits, &noise);
    let name = "whether the matrix differs between disturbed and quiet times";
    found.quiet_disturbed = told(quiet_disturbed, name, &mut found.findings)?.flatten();
    found.findings.extend(found.quiet_disturbed.iter().flat_map(windows::quiet_findings));
    let in_bands = bands::bands(pair, fits, &noise);
    found.bands = told(in_bands, "whether the matrix is the same at all periods", &mut found.findings)?;
    found.findings.extend(found.bands.iter().flat_map(bands::words::findings));
    Ok(Some(found))
}

/// What was found; where it could not be, a finding says why.
fn told<T>(found: Result<T, Error>, name: &str, findings: &mut Findings) -> Result<Option<T>, Error> {
    let why = match found {
        Ok(found) => return Ok(Some(found)),
        Err(Error::Fit(why) | Error::Unanswerable(why)) => why,
        Err(other) => return Err(other),
    };
    findings.push(Code::NotDetermined.said(format!("{name} cannot be determined: {why}")));
    Ok(None)
}
