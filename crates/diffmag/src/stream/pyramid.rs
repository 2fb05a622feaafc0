use serde::{Deserialize, Serialize};

use super::moments::{Block, Level, PRODUCTS};
use super::tile::TILE_LEVELS;

/// No series has blocks of 2^50 places.
pub const HIGHEST: u8 = 50;

/// A block of 2^level places whose neighbour is not known yet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Orphan {
    level: u8,
    place: i64,
    #[serde(flatten)]
    block: Block,
}

/// Sums of the products of Haar differences by level. Block k of level L holds the places k 2^L … (k + 1) 2^L
/// − 1, whatever piece they come from; the difference is that of 2k + 1 and 2k. A block waits until its
/// neighbour comes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Pyramid {
    /// From level 0.
    pub levels: Vec<Level>,
    orphans: Vec<Orphan>,
}

impl Pyramid {
    /// Takes a block that is known whole, missing samples and all.
    pub fn insert(&mut self, mut level: u8, mut place: i64, mut block: Block) {
        loop {
            let key = (level, place ^ 1);
            match self.orphans.binary_search_by_key(&key, |orphan| (orphan.level, orphan.place)) {
                Err(_) => {
                    let key = (level, place);
                    let at = self.orphans.partition_point(|orphan| (orphan.level, orphan.place) < key);
                    self.orphans.insert(at, Orphan { level, place, block });
                    return;
                }
                Ok(at) => {
                    let other = self.orphans.remove(at).block;
                    let (mut before, after) = if place & 1 == 0 { (block, other) } else { (other, block) };
                    let of = self.level(level);
                    match before.difference(&after, 1 << level) {
                        Some(difference) => of.add_difference(&difference),
                        None if before.count + after.count > 0 => of.broken += 1,
                        None => {}
                    }
                    before.add(&after);
                    (level, place, block) = (level + 1, place >> 1, before);
                }
            }
        }
    }

    /// Takes tiles without a sample, from one up to but not including another.
    pub fn insert_empty(&mut self, from: i64, to: i64) {
        let mut at = from;
        while at < to {
            let fits = |rise: &u32| at & ((1 << rise) - 1) == 0 && at + (1 << rise) <= to;
            let rise = (0..40).take_while(fits).last().unwrap_or(0);
            self.insert((TILE_LEVELS as u32 + rise) as u8, at >> rise, Block::default());
            at += 1 << rise;
        }
    }

    /// Whether the parts fit each other, after reading them from outside.
    pub fn is_whole(&self) -> bool {
        let key = |orphan: &Orphan| (orphan.level, orphan.place);
        self.levels.iter().all(|level| level.products.is_empty() || level.products.len() == PRODUCTS)
            && self.levels.len() <= usize::from(HIGHEST)
            && self.orphans.is_sorted_by_key(key)
            && self.orphans.iter().all(|orphan| orphan.level <= HIGHEST)
    }

    /// Takes what another pyramid holds, of other places.
    pub fn merge(&mut self, other: Pyramid) {
        for (number, level) in other.levels.iter().enumerate() {
            self.level(number as u8).add(level);
        }
        for Orphan { level, place, block } in other.orphans {
            self.insert(level, place, block);
        }
    }

    fn level(&mut self, level: u8) -> &mut Level {
        let level = usize::from(level);
        self.levels_to(level + 1);
        &mut self.levels[level]
    }

    pub fn levels_to(&mut self, levels: usize) {
        if self.levels.len() < levels {
            self.levels.resize_with(levels, Level::default);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::Statistics;
    use ::partial::Take;
    use testkit::reference::{list, reference};

    #[test]
    fn empty_tiles_are_the_same_however_they_come() {
        let (mut at_once, mut one_by_one) = (Pyramid::default(), Pyramid::default());
        at_once.insert_empty(-5, 21);
        (-5..21).for_each(|tile| one_by_one.insert_empty(tile, tile + 1));
        assert_eq!(at_once.orphans, one_by_one.orphans);
    }

    #[test]
    fn python_has_the_same_differences() {
        let reference = reference("diffmag_stream");
        let numbers = |value: &serde_json::Value| -> Vec<f64> {
            list(value).iter().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
        };
        let time = numbers(&reference["time_s"]);
        let columns: Vec<Vec<f64>> = list(&reference["columns"]).iter().map(numbers).collect();
        let mut statistics = Statistics::default();
        let all: Vec<&[f64]> = std::iter::once(&time).chain(&columns).map(Vec::as_slice).collect();
        statistics.push(&all).expect("rows");
        let levels = statistics.finish().expect("a piece").pyramid.levels;
        let expected = list(&reference["haar"]);
        assert_eq!(levels.len(), expected.len());
        let mut worst: f64 = 0.0;
        for (level, expected) in levels.iter().zip(expected) {
            assert_eq!(Some(level.count), expected["count"].as_u64());
            assert_eq!(Some(level.broken), expected["broken"].as_u64());
            let Some(products) = expected["products"].as_array().filter(|_| level.count > 0) else {
                continue;
            };
            for (i, products) in products.iter().enumerate() {
                for (j, product) in numbers(products).into_iter().enumerate() {
                    let size = (level.product(i, i).value() * level.product(j, j).value()).sqrt();
                    worst = worst.max((level.product(i, j).value() - product).abs() / size);
                }
            }
        }
        println!("worst difference {worst:.1e}");
        assert!(worst < 1e-11);
    }
}
