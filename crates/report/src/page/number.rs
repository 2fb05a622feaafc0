//! Numbers as people read them, and the ends of a series.

pub use common::number::*;

/// Smallest and largest of the values that are finite.
pub fn ends(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let finite = values.filter(|value| value.is_finite()).map(|value| [value, value]);
    finite.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
}

/// From the smallest to the largest of the values that are finite; zero without one.
pub fn span(values: impl Iterator<Item = f64>) -> f64 {
    ends(values).map_or(0.0, |[low, high]| high - low)
}
