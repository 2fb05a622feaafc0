//! Noise that is allowed for beside what is known.

use common::Noise;

/// Where no noise is known: the probability beforehand that it is white alone, and the variances of flicker
/// noise over that of white noise otherwise, alike. What has memory makes the wider intervals: with so much
/// for it they hold in 95 % under flicker noise, and more often under white noise.
const WHITE: f64 = 0.05;
const RATIOS: [f64; 7] = [0.125, 0.5, 2.0, 8.0, 32.0, 128.0, 512.0];
/// Variance of the field's noise over that of a sensor whose noise is known, where a coil makes the field.
const FIELD: [f64; 4] = [0.25, 1.0, 4.0, 16.0];

/// What has memory beside what is known.
#[derive(Clone, Copy)]
pub enum Memory {
    /// Flicker noise, 1/f.
    Flicker,
    /// A random walk, for what drifts.
    Walk,
}

impl Memory {
    /// The noise of that amplitude: density at 1 Hz, or variance in a second.
    pub fn noise(self, amplitude: f64) -> Noise {
        match self {
            Memory::Flicker => Noise { flicker_nt2_per_hz_at_1hz: Some(amplitude), ..Noise::default() },
            Memory::Walk => Noise { random_walk_nt_per_sqrt_s: Some(amplitude.sqrt()), ..Noise::default() },
        }
    }
}

/// Noise that is allowed for beside what is known, by its variance over that: white noise, and slow noise
/// with memory.
#[derive(Clone, Copy)]
pub struct More {
    pub white: f64,
    pub slow: f64,
    pub memory: Memory,
    pub probability: f64,
}

impl More {
    pub const NONE: More = More { white: 0.0, slow: 0.0, memory: Memory::Flicker, probability: 1.0 };

    /// Of the field beside a sensor whose noise is known; with a walk where it drifts.
    pub fn of_field(drifts: bool) -> impl Iterator<Item = Self> {
        let with = |memory: Memory| {
            let of = |size: &f64| [[0.5 * size, 0.5 * size], [0.0, *size]];
            FIELD.iter().flat_map(of).map(move |[white, slow]| More { white, slow, memory, ..More::NONE })
        };
        let white = FIELD.iter().map(|white| More { white: *white, ..More::NONE });
        white.chain(with(Memory::Flicker)).chain(with(Memory::Walk).filter(move |_| drifts))
    }

    /// Beside white noise of which nothing is known.
    pub fn unknown() -> Vec<Self> {
        let probability = (1.0 - WHITE) / RATIOS.len() as f64;
        let flicker = RATIOS.map(|slow| More { slow, probability, ..More::NONE });
        std::iter::once(More { probability: WHITE, ..More::NONE }).chain(flicker).collect()
    }
}
