//! Random numbers of a case.

use rand::SeedableRng;
use rand_chacha::ChaCha20Rng;
use rand_distr::{Distribution, StandardNormal, Uniform};
use sha2::{Digest, Sha256};

/// A source of numbers that belongs to a name and a seed: further sources do not change it.
#[derive(Clone, Debug)]
pub struct Draw(ChaCha20Rng);

impl Draw {
    /// The source `name` of a seed.
    pub fn new(name: &str, seed: u64) -> Self {
        let digest = Sha256::digest(format!("{name}/{seed}").as_bytes());
        Self(ChaCha20Rng::from_seed(digest.into()))
    }

    /// Between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        Uniform::new_inclusive(0.0, 1.0).map_or(low, |unit| low + (high - low) * unit.sample(&mut self.0))
    }

    /// Between two positive numbers, each octave alike.
    pub fn octaves(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// Mean 0, standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// −1 or 1.
    pub fn sign(&mut self) -> f64 {
        if self.between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 }
    }

    /// Below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.between(0.0, 1.0) * count as f64) as usize).min(count.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_repeatable_and_unlike() {
        let take = |name, seed| {
            let mut draw = Draw::new(name, seed);
            [draw.normal(), draw.between(0.0, 1.0), draw.octaves(1.0, 8.0)]
        };
        assert_eq!(take("a", 1), take("a", 1));
        assert_ne!(take("a", 1), take("b", 1));
        assert_ne!(take("a", 1), take("a", 2));
    }
}
