//! A few rows of a flight, by which mistakes of the attitude are known.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Rows that are kept.
const KEPT: usize = 256;

/// Time, s; readings, nT; the first camera's quaternion; the field in GEO, ITRF and ICRF, nT.
pub type Row = [f64; 17];

/// The rows with the largest of a mixed number of their times: the same whichever pieces they come from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "Vec<Vec<f64>>", into = "Vec<Vec<f64>>")]
pub struct Sample(BTreeMap<u64, Row>);

impl Sample {
    pub fn take(&mut self, row: Row) {
        self.0.insert(mixed(row[0]), row);
        if self.0.len() > KEPT {
            self.0.pop_first();
        }
    }

    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        self.0.values()
    }

    pub fn merge(&mut self, other: &Self) {
        other.rows().for_each(|row| self.take(*row));
    }

    /// Whether all are numbers, after reading them from outside.
    pub fn is_whole(&self) -> bool {
        self.rows().flatten().all(|value| value.is_finite())
    }
}

/// The bits of a time, mixed by a multiplication with 2⁶⁴ over the golden ratio (Knuth, The Art of Computer Programming,
/// 6.4).
fn mixed(time_s: f64) -> u64 {
    let product = time_s.to_bits().wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (product ^ (product >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

impl From<Vec<Vec<f64>>> for Sample {
    fn from(rows: Vec<Vec<f64>>) -> Self {
        let mut sample = Self::default();
        let rows = rows.into_iter().map(|row| Row::try_from(row).unwrap_or([f64::NAN; 17]));
        rows.for_each(|row| sample.take(row));
        sample
    }
}

impl From<Sample> for Vec<Vec<f64>> {
    fn from(sample: Sample) -> Self {
        sample.0.into_values().map(|row| row.to_vec()).collect()
    }
}
