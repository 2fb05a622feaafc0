//! Noise of readings, from the campaign's seed.

use common::{Axis, Instrument};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use sha2::{Digest, Sha256};

/// A source of normal numbers of its own for each name, so that a channel more changes no other.
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

/// Adds the declared white noise and rounds to the converter's codes, in the unit of the readings.
pub fn disturb(
    instrument: &Instrument,
    sensor: Axis,
    sensitivity: f64,
    step: f64,
    stream: &mut Stream,
    readings: &mut [f64],
) {
    let white_nt = instrument.noise_of(sensor).and_then(|noise| noise.white_rms_nt).unwrap_or(0.0);
    for reading in readings.iter_mut() {
        *reading += stream.normal() * white_nt / sensitivity;
        if step > 0.0 {
            *reading = (*reading / step).round() * step;
        }
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

    #[test]
    fn the_noise_is_as_declared_and_the_codes_are_whole() {
        let instrument: Instrument =
            serde_json::from_str(r#"{"noise": {"white_rms_nt": 2.0}}"#).expect("an instrument");
        let mut readings = vec![0.0; 40_000];
        disturb(&instrument, Axis::X, 4.0, 0.0, &mut Stream::new(7, "x"), &mut readings);
        let rms = (readings.iter().map(|r| r * r).sum::<f64>() / 4e4).sqrt();
        // 2 nT at 4 nT/V are 0.5 V; the rms of 40 000 has a standard deviation of 0.35 %.
        assert!((rms / 0.5 - 1.0).abs() < 0.015, "{rms}");
        disturb(&Instrument::default(), Axis::X, 4.0, 0.25, &mut Stream::new(7, "x"), &mut readings);
        assert!(readings.iter().all(|reading| (reading / 0.25).fract() == 0.0));
    }
}
