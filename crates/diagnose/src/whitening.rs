//! The noise of each channel, and with it the way to independent errors of variance one.

mod declared;

use common::{Document, Noise};
use estimate::correlated::Whitening;
use estimate::innovations::Innovations;
use estimate::stats::median;
use faer::Mat;
use rayon::prelude::*;
use std::sync::Arc;

use crate::Error;
use crate::matched::correlate;
use crate::model::State;
use crate::observed::{Channel, Observed};
pub use declared::code_nt;
use declared::{declared, estimate, known_freedom};

/// Readings up to which noise with memory is whitened by its whole covariance; beyond, by innovations on an even grid.
const LONGEST: usize = 1000;
/// A row is on a grid when it is no farther off than this share of a step.
const OFF_GRID: f64 = 0.01;
/// Most points of a grid for each row that is there.
const SPARSEST: usize = 4;

/// Periods of flicker noise that count, in lengths of the campaign.
const OLDEST: f64 = 8.0;

/// The way to independent errors in one channel.
#[derive(Clone, Debug)]
enum Way {
    /// White noise of a standard deviation, nT.
    White(f64),
    /// L⁻¹ of the whole covariance.
    Whole(Arc<Whitening>),
    /// Innovations on an even grid, of which the channel's rows are some.
    Grid(Arc<Grid>),
}

/// An even grid of times and the noise on it.
struct Grid {
    innovations: Innovations,
    /// Where on the grid each row is.
    places: Vec<usize>,
    points: usize,
}

impl std::fmt::Debug for Grid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Grid").field("points", &self.points).finish_non_exhaustive()
    }
}

impl Grid {
    fn of(noise: &Noise, time: &[f64], oldest_s: f64) -> Result<Option<Self>, Error> {
        let Some(step_s) = typical_step_s(time) else { return Ok(None) };
        let places: Vec<usize> = time.iter().map(|t| ((t - time[0]) / step_s).round() as usize).collect();
        let on_grid =
            |(t, place): (&f64, &usize)| (t - time[0] - *place as f64 * step_s).abs() < OFF_GRID * step_s;
        let points = places.last().map_or(0, |last| last + 1);
        let rising = places.windows(2).all(|pair| pair[0] < pair[1]);
        if !rising || !time.iter().zip(&places).all(on_grid) || points > SPARSEST * time.len() {
            return Ok(None);
        }
        let slowest = 1.0 / oldest_s.max(points as f64 * step_s);
        let density = |f: f64| noise.density(f.max(slowest), step_s);
        let innovations = if points == places.len() {
            Innovations::of(&density, points, step_s)?
        } else {
            let mut known = vec![false; points];
            places.iter().for_each(|place| known[*place] = true);
            Innovations::of_known(&density, &known, step_s)?
        };
        Ok(Some(Self { innovations, places, points }))
    }

    fn whiten(&self, series: &[f64]) -> Vec<f64> {
        if self.points == self.places.len() {
            return self.innovations.whiten(series);
        }
        let mut whole = vec![0.0; self.points];
        self.places.iter().zip(series).for_each(|(place, value)| whole[*place] = *value);
        let white = self.innovations.whiten(&whole);
        self.places.iter().map(|place| white[*place]).collect()
    }
}

/// The noise of all channels.
#[derive(Clone, Debug)]
pub struct NoiseModel {
    ways: Vec<Way>,
    /// Standard deviation of a reading of each channel about its mean, nT.
    pub std_nt: Vec<f64>,
    /// Degrees of freedom with which the size of the noise is known beforehand: infinite where it is declared, zero where it is
    /// estimated from the residual.
    pub known: f64,
    /// `declared` or `residuals`.
    pub source: &'static str,
}

impl NoiseModel {
    /// The noise as the document declares it, through the converters of a state; where it does not, as `residual` (nT, stacked, with
    /// `used` degrees of freedom taken by the fit) shows it: white, before there was a fit.
    pub fn of(
        document: &Document,
        observed: &Observed<'_>,
        state: &State,
        residual: &[f64],
        used: Option<usize>,
    ) -> Result<Self, Error> {
        let declared: Vec<Option<Noise>> =
            observed.channels.iter().map(|channel| declared(document, observed, state, channel)).collect();
        let known = known_freedom(&declared);
        let estimated = known == 0.0;
        let noises: Vec<Noise> = if estimated {
            estimate(document, observed, residual, used)?
        } else {
            declared.into_iter().flatten().collect()
        };
        let found: Vec<(Way, f64)> = observed
            .channels
            .par_iter()
            .zip(&noises)
            .map(|(channel, noise)| way(observed, channel, noise, !estimated))
            .collect::<Result<_, Error>>()?;
        let (ways, std_nt) = found.into_iter().unzip();
        Ok(Self { ways, std_nt, known, source: if estimated { "residuals" } else { "declared" } })
    }

    /// Whether it whitens as another does: the same declaration, through the same converters.
    pub fn same(&self, other: &Self) -> bool {
        self.known > 0.0 && self.known == other.known && self.std_nt == other.std_nt
    }

    /// Whether the noise of a channel has memory.
    pub fn remembers(&self, channel: usize) -> bool {
        !matches!(self.ways[channel], Way::White(_))
    }

    /// Mean variance of a reading over the channels, nT².
    pub fn variance(&self) -> f64 {
        self.std_nt.iter().map(|std| std * std).sum::<f64>() / self.std_nt.len().max(1) as f64
    }

    /// A stacked series whitened.
    pub fn whiten(&self, observed: &Observed<'_>, series: &[f64]) -> Vec<f64> {
        let mut white = Vec::with_capacity(series.len());
        for (channel, way) in observed.channels.iter().zip(&self.ways) {
            let part = &series[channel.range()];
            match way {
                Way::White(std) => white.extend(part.iter().map(|value| value / std)),
                Way::Whole(_) | Way::Grid(_) if part.iter().all(|value| *value == 0.0) => {
                    white.extend(std::iter::repeat_n(0.0, part.len()));
                }
                Way::Whole(whitening) => white.extend(whitening.apply_to(part)),
                Way::Grid(grid) => white.extend(grid.whiten(part)),
            }
        }
        white
    }

    /// Stacked columns whitened, on all threads.
    pub fn whiten_all(&self, observed: &Observed<'_>, columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
        columns.par_iter().map(|column| self.whiten(observed, column)).collect()
    }

    /// What a departure of one nT in the middle of a channel is whitened to, from its row on.
    pub fn response(&self, channel: usize, rows: usize) -> Vec<f64> {
        let mut departure = vec![0.0; rows];
        departure[rows / 2] = 1.0;
        let white = match &self.ways[channel] {
            Way::White(std) => return vec![1.0 / std],
            Way::Whole(whitening) => whitening.apply_to(&departure),
            Way::Grid(grid) => grid.whiten(&departure),
        };
        white[rows / 2..].to_vec()
    }

    /// A whitened series through that response, backwards: what a departure in each row has to do with it.
    pub fn filtered(&self, channel: usize, white: &[f64]) -> Vec<f64> {
        correlate(white, &self.response(channel, white.len()))
    }
}

/// The middle of the steps of rising times.
fn typical_step_s(time: &[f64]) -> Option<f64> {
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let step = median(&steps);
    (step > 0.0 && step.is_finite()).then_some(step)
}

/// Variance of flicker noise and random walk of readings about their mean: the density over the recording's frequencies.
fn flicker_variance(noise: &Noise, time: &[f64]) -> f64 {
    let step = 1.0 / (time[time.len() - 1] - time[0]);
    let memory = Noise { white_rms_nt: None, ..noise.clone() };
    (1..=time.len() / 2).map(|k| memory.density(k as f64 * step, 0.0) * step).sum()
}

/// Flicker noise slower than its recording, as waves whose products are its covariance, an octave each. A declaration ends at one over the
/// recording's length, but such noise did not begin with it: levels and trends of a recording are part of it. What is slower than the
/// whole campaign is one level throughout.
fn older(noise: &Noise, time: &[f64], oldest_s: f64) -> Vec<Vec<f64>> {
    let flicker = Noise { white_rms_nt: None, random_walk_nt_per_sqrt_s: None, ..noise.clone() };
    let mut above = 1.0 / (time[time.len() - 1] - time[0]);
    let mut waves = Vec::new();
    while above.is_finite() && above > 1.0 / oldest_s {
        let middle = above * std::f64::consts::FRAC_1_SQRT_2;
        let rms = (flicker.density(middle, 0.0) * 0.5 * above).sqrt();
        let wave = |of: fn(f64) -> f64| {
            time.iter().map(|t| rms * of(std::f64::consts::TAU * middle * (t - time[0]))).collect()
        };
        waves.extend([wave(f64::cos), wave(f64::sin)]);
        above *= 0.5;
    }
    waves
}

/// Where the noise was estimated from a residual, what is slower than a recording may be what is looked for, and is not taken for noise.
fn way(
    observed: &Observed<'_>,
    channel: &Channel,
    noise: &Noise,
    declared: bool,
) -> Result<(Way, f64), Error> {
    let rows = channel.rows.len();
    let memory = noise.flicker_nt2_per_hz_at_1hz.unwrap_or(0.0) > 0.0
        || noise.random_walk_nt_per_sqrt_s.unwrap_or(0.0) > 0.0;
    let time = observed.times(channel).filter(|_| memory);
    let white = noise.white_rms_nt.unwrap_or(0.0);
    let oldest_s = observed.span().filter(|_| declared).map_or(0.0, |(_, length)| OLDEST * length);
    let Some(time) = time else { return Ok((Way::White(white), white)) };
    if rows > LONGEST {
        let Some(grid) = Grid::of(noise, &time, oldest_s)? else {
            return Err(Error::Undetermined(format!(
                "recording \"{}\": {rows} readings at uneven times whose noise has memory, where at most {LONGEST} can be taken; \
                 bring them to an even step, or give a part",
                observed.runs[channel.run].recording.id
            )));
        };
        let std = (white * white + flicker_variance(noise, &time)).sqrt();
        return Ok((Way::Grid(Arc::new(grid)), std));
    }
    let covariance = noise::covariance(noise, rows, Some(&time)).map_err(|error| {
        Error::Document(common::Error::document(
            observed.runs[channel.run].path.clone(),
            error.to_string(),
            "exponents from 0 to 2, and times without such gaps",
        ))
    })?;
    let mean: f64 = (0..rows).map(|row| covariance[row * rows + row]).sum::<f64>() / rows as f64;
    let older = older(noise, &time, oldest_s);
    let matrix = Mat::from_fn(rows, rows, |i, j| {
        covariance[i * rows + j] + older.iter().map(|wave| wave[i] * wave[j]).sum::<f64>()
    });
    Ok((Way::Whole(Arc::new(Whitening::of(&[matrix])?)), mean.sqrt()))
}
