use serde::{Deserialize, Serialize};

use super::moments::Block;
use super::pyramid::HIGHEST;
use super::tile::TILE_LEVELS;

/// Blocks at most, from the first to the last.
const MOST: i64 = 64;

/// A block of 2^level places with the places at which its samples begin and end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Stretch {
    place: i64,
    /// First place with a sample.
    pub first: i64,
    /// Last place with one.
    pub last: i64,
    #[serde(flatten)]
    pub block: Block,
}

/// The series in a few blocks, so long that all lie within 64: what is slowest in it, gaps and ragged ends
/// included.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Profile {
    /// A block has 2^level places.
    pub level: u8,
    /// Blocks with a sample, in order.
    pub stretches: Vec<Stretch>,
}

impl Default for Profile {
    fn default() -> Self {
        Profile { level: TILE_LEVELS as u8, stretches: Vec::new() }
    }
}

impl Profile {
    /// Whether the parts fit each other, after reading them from outside.
    pub fn is_whole(&self) -> bool {
        (TILE_LEVELS as u8..=HIGHEST).contains(&self.level)
            && self.stretches.is_sorted_by_key(|stretch| stretch.place)
            && self.stretches.iter().all(|stretch| stretch.block.count > 0 && stretch.first <= stretch.last)
    }

    /// Takes samples between two places that lie in one tile.
    pub fn add(&mut self, first: i64, last: i64, block: &Block) {
        if block.count > 0 {
            self.put(Stretch { place: first >> self.level, first, last, block: block.clone() });
            self.coarsen();
        }
    }

    pub fn merge(&mut self, mut other: Profile) {
        while self.level < other.level {
            self.double();
        }
        while other.level < self.level {
            other.double();
        }
        other.stretches.into_iter().for_each(|stretch| self.put(stretch));
        self.coarsen();
    }

    fn put(&mut self, stretch: Stretch) {
        match self.stretches.binary_search_by_key(&stretch.place, |known| known.place) {
            Err(at) => self.stretches.insert(at, stretch),
            Ok(at) => {
                let known = &mut self.stretches[at];
                known.first = known.first.min(stretch.first);
                known.last = known.last.max(stretch.last);
                known.block.add(&stretch.block);
            }
        }
    }

    fn coarsen(&mut self) {
        while let [first, .., last] = self.stretches.as_slice()
            && last.place - first.place >= MOST
        {
            self.double();
        }
    }

    fn double(&mut self) {
        self.level += 1;
        for mut stretch in std::mem::take(&mut self.stretches) {
            stretch.place >>= 1;
            self.put(stretch);
        }
    }
}
