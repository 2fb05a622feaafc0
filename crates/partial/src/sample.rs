//! A few rows of a series.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// At most `KEPT` rows of `WIDTH` numbers, times first: those whose times have the smallest hashes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Vec<Vec<f64>>", into = "Vec<Vec<f64>>")]
pub struct Sample<const WIDTH: usize, const KEPT: usize>(BTreeMap<u64, [f64; WIDTH]>);

impl<const WIDTH: usize, const KEPT: usize> Sample<WIDTH, KEPT> {
    /// Takes a row, where it is one of those that are kept.
    pub fn take(&mut self, row: [f64; WIDTH]) {
        let key = hash(row[0]);
        if self.0.len() == KEPT {
            match self.0.last_entry() {
                Some(last) if key < *last.key() => drop(last.remove()),
                _ => return,
            }
        }
        self.0.insert(key, row);
    }

    /// The rows in the order of time.
    pub fn rows(&self) -> Vec<[f64; WIDTH]> {
        let mut rows: Vec<[f64; WIDTH]> = self.0.values().copied().collect();
        rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        rows
    }

    /// Takes those of another.
    pub fn merge(&mut self, other: &Self) {
        other.0.values().for_each(|row| self.take(*row));
    }

    /// Whether all are numbers, after reading them from outside.
    pub fn is_whole(&self) -> bool {
        self.0.len() <= KEPT && self.0.values().flatten().all(|value| value.is_finite())
    }
}

/// A row of another width is one without numbers.
impl<const WIDTH: usize, const KEPT: usize> From<Vec<Vec<f64>>> for Sample<WIDTH, KEPT> {
    fn from(rows: Vec<Vec<f64>>) -> Self {
        let rows = rows.into_iter().map(|row| row.try_into().unwrap_or([f64::NAN; WIDTH]));
        Self(rows.map(|row| (hash(row[0]), row)).collect())
    }
}

impl<const WIDTH: usize, const KEPT: usize> From<Sample<WIDTH, KEPT>> for Vec<Vec<f64>> {
    fn from(sample: Sample<WIDTH, KEPT>) -> Self {
        sample.rows().into_iter().map(Vec::from).collect()
    }
}

/// The last steps of SplitMix64.
///
/// Source: G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014,
/// 453–472.
fn hash(time_s: f64) -> u64 {
    let mixed = time_s.to_bits().wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}
