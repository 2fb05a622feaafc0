//! Bins of neighbouring numbers k = 1, 2, …, narrow beside their frequencies.

use std::ops::Range;

/// Widest bin, as a share of its lowest frequency.
pub const WIDEST_BIN: f64 = 0.02;

/// Places of k = 1 … `count` in bins; the first is that of k = 1.
pub fn bins(count: usize) -> impl Iterator<Item = Range<usize>> {
    let next = move |from: usize| from + ((WIDEST_BIN * (from + 1) as f64) as usize).max(1);
    let starts = std::iter::successors(Some(0), move |from| Some(next(*from)));
    starts.take_while(move |from| *from < count).map(move |from| from..next(from).min(count))
}
