//! Series, as spectra need them.

use crate::Error;
use crate::number::counted;

/// What is expected of the times of a series.
pub const EVEN_TIMES: &str = "increasing times without gaps, most of them evenly spaced: ingest --sort sorts rows by time, series cut keeps a part without gaps, series resample --step S makes even steps";

/// A series with each missing sample filled by the mean of its neighbours that are there; more than one in a
/// hundred missing is refused with their number, at a path of the document.
pub fn filled(column: Vec<f64>, path: &str) -> Result<Vec<f64>, Error> {
    let missing = column.iter().filter(|value| !value.is_finite()).count();
    if missing * 100 > column.len() {
        let found = format!("{missing} of {} missing", counted(column.len(), "reading"));
        let expected = "at most 1 %; a spectrum needs a series without gaps: series cut --from T --to T keeps a part without them";
        return Err(Error::document(path, found, expected));
    }
    if missing == 0 {
        return Ok(column);
    }
    let at = |row: usize| {
        if column[row].is_finite() {
            return column[row];
        }
        let before = column[..row].iter().rev().find(|value| value.is_finite());
        let after = column[row..].iter().find(|value| value.is_finite());
        let known: Vec<f64> = before.into_iter().chain(after).copied().collect();
        known.iter().sum::<f64>() / known.len() as f64
    };
    Ok((0..column.len()).map(at).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_gaps_are_filled() {
        let mut column = vec![1.0; 200];
        (column[3], column[5], column[4]) = (2.0, 4.0, f64::NAN);
        assert!(filled(column.clone(), "").is_ok_and(|all| all[4] == 3.0));
        column[10..13].fill(f64::NAN);
        assert!(filled(column, "").is_err_and(|error| error.to_string().contains("4 of 200 readings")));
    }
}
