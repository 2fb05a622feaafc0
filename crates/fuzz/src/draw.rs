//! The random choices of a case.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A source of choices that belongs to a seed and a case: other cases do not change it.
#[derive(Clone, Debug)]
pub struct Draw(ChaCha8Rng);

impl Draw {
    pub fn new(seed: u64, case: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(case);
        Self(generator)
    }

    /// Below `count`; zero where there is nothing to choose from.
    pub fn below(&mut self, count: usize) -> usize {
        if count == 0 { 0 } else { self.0.random_range(0..count as u64) as usize }
    }

    pub fn between(&mut self, low: usize, high: usize) -> usize {
        low + self.below(high.saturating_sub(low) + 1)
    }

    /// True in this share of cases.
    pub fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }

    /// One of a list that is not empty.
    pub fn of<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.below(list.len())]
    }

    /// One of the parts of a text between bars.
    pub fn part(&mut self, text: &'static str) -> &'static str {
        let parts: Vec<&str> = text.split('|').collect();
        parts[self.below(parts.len())]
    }

    pub fn weighted<'a, T>(&mut self, list: &'a [(usize, T)]) -> &'a T {
        let mut left = self.below(list.iter().map(|(weight, _)| weight).sum());
        for (weight, item) in list {
            if left < *weight {
                return item;
            }
            left -= weight;
        }
        &list[0].1
    }

    pub fn shuffle<T>(&mut self, list: &mut [T]) {
        for last in (1..list.len()).rev() {
            list.swap(last, self.below(last + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Draw;

    #[test]
    fn a_case_is_its_own() {
        let take = |seed, case| {
            let mut draw = Draw::new(seed, case);
            [draw.below(1000), draw.below(1000), draw.between(5, 1000)]
        };
        assert_eq!(take(1, 2), take(1, 2));
        assert!(take(1, 2) != take(1, 3) && take(1, 2) != take(2, 2));
        assert_eq!(Draw::new(1, 1).below(0), 0);
        assert_eq!(*Draw::new(1, 1).weighted(&[(0, "never"), (3, "always")]), "always");
    }
}
