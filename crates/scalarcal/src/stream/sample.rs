//! A sample of the rows of a series, the same whichever pieces they come from: those whose times have the
//! smallest hash values.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const KEPT: usize = 128;

/// Time (s), readings, magnitude (nT).
pub type Row = [f64; 5];

/// The rows by their hash values.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Vec<Row>", into = "Vec<Row>")]
pub struct Sample(BTreeMap<u64, Row>);

impl Sample {
    pub fn take(&mut self, row: Row) {
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
    pub fn rows(&self) -> Vec<Row> {
        let mut rows: Vec<Row> = self.0.values().copied().collect();
        rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        rows
    }

    /// Takes those of another.
    pub fn merge(&mut self, other: &Self) {
        other.0.values().for_each(|row| self.take(*row));
    }

    /// Whether all are numbers, after reading them from outside.
    pub fn is_whole(&self) -> bool {
        self.0.values().flatten().all(|value| value.is_finite())
    }
}

impl From<Vec<Row>> for Sample {
    fn from(rows: Vec<Row>) -> Self {
        let mut sample = Self::default();
        rows.into_iter().for_each(|row| sample.take(row));
        sample
    }
}

impl From<Sample> for Vec<Row> {
    fn from(sample: Sample) -> Self {
        sample.rows()
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
