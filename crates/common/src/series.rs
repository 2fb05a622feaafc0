//! Even series, as spectra need them.

/// The step of times that are even (each within a quarter of a step of its place), all there, and rise; else None.
pub fn even_step_s(time: &[f64]) -> Option<f64> {
    let rows = time.len();
    let step_s = if rows > 1 { (time[rows - 1] - time[0]) / (rows - 1) as f64 } else { f64::NAN };
    let even = |(row, t): (usize, &f64)| (t - time[0] - row as f64 * step_s).abs() <= step_s / 4.0;
    (step_s > 0.0 && time.iter().enumerate().all(even)).then_some(step_s)
}

/// The step of times that would be even if none were missing (each within a quarter of a step of its place, at least half of the places
/// there), and the place of each; else None.
pub fn even_places(time: &[f64]) -> Option<(f64, Vec<usize>)> {
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() || steps.iter().any(|step| !step.is_finite() || *step <= 0.0) {
        return None;
    }
    let length = time[time.len() - 1] - time[0];
    let middle = steps.len() / 2;
    let (_, median, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    // The mean between gaps: of times printed to the millisecond, the median is off by their last digit.
    let longest = 1.5 * *median;
    let near = || steps.iter().filter(|step| **step < longest);
    let usual = near().sum::<f64>() / near().count() as f64;
    let last: f64 = steps.iter().map(|step| (step / usual).round()).sum();
    let step_s = length / last;
    let places: Vec<usize> = time.iter().map(|t| ((t - time[0]) / step_s).round() as usize).collect();
    let near = |(t, place): (&f64, &usize)| (t - time[0] - *place as f64 * step_s).abs() <= step_s / 4.0;
    let fits = last < 2.0 * time.len() as f64
        && places.windows(2).all(|pair| pair[1] > pair[0])
        && time.iter().zip(&places).all(near);
    fits.then_some((step_s, places))
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
    fn places_of_times_with_gaps() {
        let time = [0.0, 1.001, 2.0, 5.0, 6.0, 6.999, 8.0];
        let (step, places) = even_places(&time).expect("even but for a gap");
        assert_eq!((step, places), (1.0, vec![0, 1, 2, 5, 6, 7, 8]));
        assert_eq!(even_places(&[0.0, 1.0, 2.5, 3.5, 4.5, 5.5]), None);
        assert_eq!(even_places(&[0.0, 1.0, 2.0, 30.0]), None);
        assert_eq!(even_places(&[0.0, 1.0, 1.0]), None);
        // Three a second, printed to the millisecond, with a gap.
        let printed = |row: u32| (f64::from(row) / 3.0 * 1e3).round() / 1e3;
        let rows: Vec<u32> = (0..30_000).filter(|row| !(700..900).contains(row)).collect();
        let (step, places) =
            even_places(&rows.iter().map(|row| printed(*row)).collect::<Vec<_>>()).expect("even");
        assert!(
            (step - 1.0 / 3.0).abs() < 1e-7
                && places.iter().zip(&rows).all(|(place, row)| *place == *row as usize)
        );
    }

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
