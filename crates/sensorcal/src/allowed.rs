//! The covariances over which the intervals of a fit are averaged.

use common::{FitNoise, Noise};
use estimate::correlated::{CorrelatedFit, Root, Whitening};
use estimate::stats;
use faer::{Mat, MatMut};
use std::sync::Arc;

use crate::{Error, Result};

/// Covariances that weigh less than this are left out of further fits.
pub const WEIGHTY: f64 = 1e-3;

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

/// Noise allowed for beside the known, by its variance over that: white, and slow with memory.
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

/// The rows of one recording: how many, and when, where that is known.
pub type Rows = (usize, Option<Vec<f64>>);

/// Noise with memory as a sum of processes, by which readings are whitened in one pass.
#[derive(Debug)]
struct InOnePass(noise::Whitening);

impl Root for InOnePass {
    fn rows(&self) -> usize {
        self.0.rows()
    }

    fn log_determinant(&self) -> f64 {
        self.0.log_determinant()
    }

    fn whiten(&self, columns: MatMut<'_, f64>) {
        let each = columns.col_iter_mut().map(|column| {
            column.try_as_col_major_mut().expect("columns of a matrix lie in one piece").as_slice_mut()
        });
        self.0.whiten_all(&mut each.collect::<Vec<&mut [f64]>>());
    }
}

#[derive(Clone, Default)]
pub struct Allowed {
    pub whitenings: Vec<Whitening>,
    /// For each, the share of noise with memory in the variance of a reading.
    memory_shares: Vec<f64>,
    source: String,
    known: bool,
}

impl Allowed {
    /// None as yet; where the noise is from, in words, and whether it is that of a known sensor.
    pub fn none(source: String, known: bool) -> Self {
        Self { source, known, ..Self::default() }
    }

    /// One more with its probability beforehand: for each recording, by its number and rows, the covariance as
    /// rows of rows, nT², made sure of by a billionth of its diagonal, and the share of noise with memory in
    /// the variance of a reading.
    pub fn add(
        &mut self,
        recordings: &[Rows],
        probability: f64,
        block: impl Fn(usize, usize) -> Result<(Vec<f64>, f64)>,
    ) -> Result<()> {
        let total: usize = recordings.iter().map(|(rows, _)| rows).sum();
        let mut blocks = Vec::new();
        let mut memory_share = 0.0;
        for (number, (rows, _)) in recordings.iter().enumerate() {
            let (covariance, share) = block(number, *rows)?;
            let sure = |i: usize, j: usize| if i == j { 1.0 + 1e-9 } else { 1.0 };
            blocks.push(Mat::from_fn(*rows, *rows, |i, j| covariance[i * rows + j] * sure(i, j)));
            memory_share += share * *rows as f64 / total as f64;
        }
        self.whitenings.push(Whitening::of(&blocks)?.weighing(probability));
        self.memory_shares.push(memory_share);
        Ok(())
    }

    /// One more for long recordings, in one pass over the readings: what is known, and white noise and
    /// flicker noise besides, each with its variance over that of what is known.
    pub fn add_long(&mut self, recordings: &[Rows], known: &[Noise], more: More) -> Result<()> {
        let total: usize = recordings.iter().map(|(rows, _)| rows).sum();
        let mut groups: Vec<Arc<dyn Root>> = Vec::new();
        let mut memory_share = 0.0;
        for (rows, time) in recordings {
            let time = time.as_deref();
            let length_s = time.and_then(|time| Some(time.last()? - time.first()?)).unwrap_or(0.0);
            let sum = |noises: &[Noise]| {
                noise::Whitening::of_sum(noises, time, *rows, length_s).map_err(undetermined)
            };
            let mut noises = known.to_vec();
            if noises[0].white_rms_nt == Some(0.0) && length_s == 0.0 {
                // Flicker noise alone, and no times: the readings are as good as independent.
                noises[0].white_rms_nt = Some(1.0);
            }
            let white = noises[0].white_rms_nt.unwrap_or(0.0).powi(2);
            let mean = sum(&noises)?.variance_nt2();
            noises[0].white_rms_nt = Some((white + more.white * mean).sqrt());
            let mut walk = None;
            if more.slow > 0.0 && length_s > 0.0 {
                let size = sum(&[more.memory.noise(1.0)])?.variance_nt2();
                let slow = more.memory.noise(more.slow * mean / size);
                match more.memory {
                    Memory::Flicker => noises.push(slow),
                    Memory::Walk => walk = Some(slow),
                }
            }
            // As in the full matrix: flicker noise has a level, a walk that is added has none.
            let each = noises.iter().map(|noise| noise::mean_variance(noise, *rows, time));
            let level = each.sum::<Result<f64, _>>().map_err(undetermined)?;
            noises.extend(walk);
            let whitening = sum(&noises)?;
            let levelled = !whitening.is_white() && level > 0.0;
            let whitening = if levelled { whitening.with_level(level.sqrt()) } else { whitening };
            groups.push(Arc::new(InOnePass(whitening)));
            // About the mean of the recording, as `mean` is.
            let alone = white * (1.0 - 1.0 / (*rows as f64).max(1.0));
            let share = if mean > 0.0 {
                1.0 - (alone / mean + more.white) / (1.0 + more.white + more.slow)
            } else {
                0.0
            };
            memory_share += share * *rows as f64 / total as f64;
        }
        self.whitenings.push(Whitening::by(groups).weighing(more.probability));
        self.memory_shares.push(memory_share);
        Ok(())
    }

    /// Those that a fit gave some weight.
    pub fn weighty(&self, fit: &CorrelatedFit) -> Self {
        self.only(|at| fit.mixture.weights()[at] >= WEIGHTY)
    }

    /// The number of the one that a fit gave most weight.
    pub fn best(&self, fit: &CorrelatedFit) -> usize {
        (0..fit.mixture.weights().len())
            .max_by(|a, b| fit.mixture.weights()[*a].total_cmp(&fit.mixture.weights()[*b]))
            .unwrap_or(0)
    }

    pub fn likeliest(&self, fit: &CorrelatedFit) -> Self {
        let best = self.best(fit);
        self.only(|at| at == best)
    }

    /// Each with its standard deviations in each recording times a factor.
    pub fn scaled(&self, scales: &[f64]) -> Self {
        let whitenings = self.whitenings.iter().map(|white| white.scaled(scales));
        Self { whitenings: whitenings.collect(), ..self.clone() }
    }

    pub fn is_own(&self) -> bool {
        self.known && self.whitenings.len() == 1
    }

    pub fn own(&self) -> Option<Self> {
        self.known.then(|| self.only(|at| at == 0))
    }

    fn only(&self, keep: impl Fn(usize) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.whitenings.len()).filter(|at| keep(*at)).collect();
        Self {
            whitenings: kept.iter().map(|at| self.whitenings[*at].clone()).collect(),
            memory_shares: kept.iter().map(|at| self.memory_shares[*at]).collect(),
            ..self.clone()
        }
    }

    pub fn describe(&self, fit: &CorrelatedFit) -> FitNoise {
        let rms = (fit.residuals.iter().map(|r| r * r).sum::<f64>() / fit.residuals.len() as f64).sqrt();
        // The first covariance is the sensor's own noise, where that is known.
        let own = |white: &Whitening| {
            let squares: f64 = white.apply_to(&fit.residuals).iter().map(|r| r * r).sum();
            squares / fit.freedom
        };
        let shares = self.memory_shares.iter().zip(fit.mixture.weights());
        FitNoise {
            source: self.source.clone(),
            rms_nt: rms,
            variance_factor: self.whitenings.first().filter(|_| self.known).map(own),
            flicker_share: shares.map(|(share, weight)| share * weight).sum(),
            degrees_of_freedom: fit.freedom,
            coverage_factor_95: stats::coverage_factor(0.95, fit.freedom),
        }
    }
}

/// What a noise cannot be, as a refusal.
pub fn undetermined(error: noise::NoiseError) -> Error {
    Error::Unanswerable(error.to_string())
}
