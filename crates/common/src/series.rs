//! Even series, as spectra need them.

/// The step of times that are even (each within a quarter of a step of its place), all there, and rise; else None.
pub fn even_step_s(time: &[f64]) -> Option<f64> {
    let rows = time.len();
    let step_s = if rows > 1 { (time[rows - 1] - time[0]) / (rows - 1) as f64 } else { f64::NAN };
    let even = |(row, t): (usize, &f64)| (t - time[0] - row as f64 * step_s).abs() <= step_s / 4.0;
    (step_s > 0.0 && time.iter().enumerate().all(even)).then_some(step_s)
}

/// A series with each missing sample filled by the mean of its neighbours that are there; more than one in a hundred missing
/// is refused with their number.
pub fn filled(column: &[f64]) -> Result<Vec<f64>, usize> {
    let missing = column.iter().filter(|value| !value.is_finite()).count();
    if missing * 100 > column.len() {
        return Err(missing);
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
    fn evenness_and_gaps() {
        assert_eq!(even_step_s(&[0.0, 1.1, 2.0, 3.0]), Some(1.0));
        assert_eq!(even_step_s(&[0.0, 1.0, 2.0, 4.0]), None);
        assert_eq!(even_step_s(&[0.0, f64::NAN, 2.0]), None);
        assert_eq!(even_step_s(&[1.0]), None);
        let mut column = vec![1.0; 200];
        (column[3], column[5], column[4]) = (2.0, 4.0, f64::NAN);
        assert_eq!(filled(&column).map(|all| all[4]), Ok(3.0));
        column[10..13].fill(f64::NAN);
        assert_eq!(filled(&column), Err(4));
    }
}
