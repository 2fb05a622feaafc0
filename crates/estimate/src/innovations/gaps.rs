//! Missing rows of a long even series, filled with what the known rows say of them.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use std::ops::Range;

use crate::Error;

/// Known rows on either side of a gap that count each for itself; those farther off count by means.
const SINGLE: usize = 32;
/// A mean stands for all rows of its range if so large a share of them is known.
const LEAST_KNOWN: f64 = 0.25;

/// The gaps of a series.
pub(super) struct Gaps {
    /// The known rows.
    places: Vec<usize>,
    gaps: Vec<Gap>,
}

/// A run of missing rows x_g, and weights of means y over ranges of known rows, ever longer with their distance: the
/// expectation of x_g given y is C_gy C_yy⁻¹ y.
struct Gap {
    missing: Range<usize>,
    /// Ranges of `places`.
    around: Vec<Range<usize>>,
    weights: Mat<f64>,
}

impl Gaps {
    pub(super) fn of(lags: &[f64], known: &[bool]) -> Result<Self, Error> {
        let places: Vec<usize> = (0..known.len()).filter(|row| known[*row]).collect();
        let sums = Sums::of(lags);
        let mut gaps = Vec::new();
        let mut row = 0;
        while row < known.len() {
            let from = row;
            while row < known.len() && !known[row] {
                row += 1;
            }
            if row > from {
                gaps.push(Gap::of(from..row, &places, &sums)?);
            }
            row += 1;
        }
        Ok(Self { places, gaps })
    }

    pub(super) fn fill(&self, series: &mut [f64]) {
        let mut sums = vec![0.0];
        let mut sum = 0.0;
        for place in &self.places {
            sum += series[*place];
            sums.push(sum);
        }
        for gap in &self.gaps {
            let mean = |range: &Range<usize>| match range.len() {
                1 => series[self.places[range.start]],
                count => (sums[range.end] - sums[range.start]) / count as f64,
            };
            let means: Vec<f64> = gap.around.iter().map(mean).collect();
            for (i, row) in gap.missing.clone().enumerate() {
                series[row] = means.iter().enumerate().map(|(j, mean)| gap.weights[(i, j)] * mean).sum();
            }
        }
    }
}

impl Gap {
    fn of(missing: Range<usize>, places: &[usize], sums: &Sums) -> Result<Self, Error> {
        let around = around(places.partition_point(|place| *place < missing.start), places);
        let rows = |range: &Range<usize>| places[range.start]..places[range.end - 1] + 1;
        let ranges: Vec<Range<usize>> = around.iter().map(rows).collect();
        let singles: Vec<Range<usize>> = missing.clone().map(|row| row..row + 1).collect();
        let between = |from: &[Range<usize>], to: &[Range<usize>]| {
            Mat::from_fn(from.len(), to.len(), |i, j| sums.covariance(&from[i], &to[j]))
        };
        let factor = between(&ranges, &ranges).llt(Side::Lower).map_err(|error| Error::Decomposition {
            rows: ranges.len(),
            columns: ranges.len(),
            reason: format!("{error:?}"),
        })?;
        let weights = factor.solve(&between(&ranges, &singles)).transpose().to_owned();
        Ok(Self { missing, around, weights })
    }
}

/// Ranges of the known rows before and after the place numbered `middle`: single ones, then 32, 64, … together.
fn around(middle: usize, places: &[usize]) -> Vec<Range<usize>> {
    let lengths = || std::iter::repeat_n(1, SINGLE).chain((0..).map(|octave| SINGLE << octave));
    let enough = |range: &Range<usize>| {
        let rows = places[range.end - 1] + 1 - places[range.start];
        range.len() as f64 >= LEAST_KNOWN * rows as f64
    };
    let before = lengths().scan(middle, |end, length| {
        let range = end.saturating_sub(length)..*end;
        *end = range.start;
        (!range.is_empty()).then_some(range)
    });
    let after = lengths().scan(middle, |start, length| {
        let range = *start..(*start + length).min(places.len());
        *start = range.end;
        (!range.is_empty()).then_some(range)
    });
    before.take_while(enough).chain(after.take_while(enough)).collect()
}

/// Sums of the autocovariance over pairs of ranges.
struct Sums<'a> {
    lags: &'a [f64],
    /// G with G(m + 1) − 2 G(m) + G(m − 1) = r_m, G(0) = 0, G(−m) = G(m).
    twice: Vec<f64>,
}

impl<'a> Sums<'a> {
    fn of(lags: &'a [f64]) -> Self {
        let mut twice = vec![0.0, lags[0] / 2.0];
        for m in 1..lags.len() {
            twice.push(2.0 * twice[m] - twice[m - 1] + lags[m]);
        }
        Self { lags, twice }
    }

    /// Covariance of the means over two ranges of rows.
    fn covariance(&self, a: &Range<usize>, b: &Range<usize>) -> f64 {
        if a.len() == 1 && b.len() == 1 {
            return self.lags[a.start.abs_diff(b.start)];
        }
        let sum = |from: usize, to: usize| self.twice[from.abs_diff(to)];
        let all = sum(a.end, b.start) - sum(a.end, b.end) - sum(a.start, b.start) + sum(a.start, b.end);
        all / (a.len() * b.len()) as f64
    }
}
