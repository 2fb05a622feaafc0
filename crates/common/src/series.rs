//! Series, as spectra need them.

/// A series with each missing sample filled by the mean of its neighbours that are there; more than one in a
/// hundred missing is refused with their number.
pub fn filled(column: Vec<f64>) -> Result<Vec<f64>, usize> {
    let missing = column.iter().filter(|value| !value.is_finite()).count();
    if missing * 100 > column.len() {
        return Err(missing);
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
        assert_eq!(filled(column.clone()).map(|all| all[4]), Ok(3.0));
        column[10..13].fill(f64::NAN);
        assert_eq!(filled(column), Err(4));
    }
}
