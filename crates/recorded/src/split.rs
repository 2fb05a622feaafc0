//! What is fitted and what is left out, by time: the later part is never seen by the fit.

use super::series::Series;

/// A series cut at a moment.
#[derive(Clone, Debug)]
pub struct Split {
    /// What is fitted.
    pub fitted: Series,
    /// What is predicted.
    pub left_out: Series,
}

impl Split {
    /// Cut where `time_s` reaches `at_s`.
    pub fn at(series: &Series, at_s: f64) -> Self {
        let time = series.column("time_s");
        let fitted = series.filter(|row| time[row] < at_s);
        let left_out = series.filter(|row| time[row] >= at_s);
        Self { fitted, left_out }
    }

    /// Cut after a share of the time that the series covers.
    pub fn share(series: &Series, share: f64) -> Self {
        let time = series.column("time_s");
        let (first, last) = (time.first().copied().unwrap_or(0.0), time.last().copied().unwrap_or(0.0));
        Self::at(series, first + share * (last - first))
    }
}

/// The longest part of a series without a gap of more than `gap_s`.
pub fn longest_part(series: &Series, gap_s: f64) -> Series {
    let time = series.column("time_s");
    let mut longest = 0..0;
    let mut from = 0;
    for row in 0..time.len() {
        if row > 0 && time[row] - time[row - 1] > gap_s {
            from = row;
        }
        if row + 1 - from > longest.len() {
            longest = from..row + 1;
        }
    }
    series.filter(|row| longest.contains(&row))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_row_is_in_both_parts_and_none_is_lost() {
        let times: Vec<f64> = (0..100).map(|k| 10.0 + f64::from(k)).collect();
        let series = Series::default().with("time_s", times);
        let split = Split::share(&series, 2.0 / 3.0);
        let (fitted, left_out) = (split.fitted.column("time_s"), split.left_out.column("time_s"));
        assert_eq!((fitted.len(), left_out.len()), (66, 34));
        assert!(fitted.iter().all(|t| *t < left_out[0]));
    }

    #[test]
    fn the_part_between_two_gaps() {
        let series = Series::default().with("time_s", vec![0.0, 1.0, 9.0, 10.0, 11.0, 20.0, 21.0]);
        assert_eq!(longest_part(&series, 2.0).column("time_s"), [9.0, 10.0, 11.0]);
        assert_eq!(longest_part(&Series::default(), 2.0).rows(), 0);
    }
}
