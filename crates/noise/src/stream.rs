use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use sha2::{Digest, Sha256};

/// A source of normal numbers of its own for each name.
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream `name` of a seed.
    pub fn new(seed: u64, name: &str) -> Self {
        let digest = Sha256::digest(name.as_bytes());
        let mut number = [0; 8];
        number.copy_from_slice(&digest[..8]);
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(u64::from_le_bytes(number));
        Stream(generator)
    }

    /// The next number with mean 0 and standard deviation 1.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_repeatable_and_unlike() {
        let take = |seed, name| {
            let mut stream = Stream::new(seed, name);
            [stream.normal(), stream.normal(), stream.normal()]
        };
        assert_eq!(take(1, "a"), take(1, "a"));
        assert_ne!(take(1, "a"), take(1, "b"));
        assert_ne!(take(1, "a"), take(2, "a"));
    }
}
