//! The noise of each channel, and with it the way to independent errors of variance one.

use common::{Axis, Document, Noise, series::even_step_s};
use estimate::correlated::Whitening;
use estimate::innovations::Innovations;
use estimate::periodogram::periodogram;
use estimate::stats::median;
use estimate::whittle::{self, White};
use faer::Mat;
use nalgebra::Vector3;
use physics::{EffectInstance, Kind, SensorConstants, Setting, Unit};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;

use crate::Error;
use crate::matched::correlate;
use crate::observed::{Channel, Observed, Reader};

/// Readings up to which noise with memory is whitened by its whole covariance; beyond, by innovations on an even grid.
const LONGEST: usize = 1000;
/// A row is on a grid when it is no farther off than this share of a step.
const OFF_GRID: f64 = 0.01;
/// Most points of a grid for each row that is there.
const SPARSEST: usize = 4;
/// Fewest readings of an even series that a spectrum is fitted to.
const SPECTRUM_FROM: usize = 64;
/// Fewest readings of a sensor that give its white noise by themselves.
const ALONE_FROM: usize = 40;

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
    fn of(noise: &Noise, time: &[f64]) -> Result<Option<Self>, Error> {
        let Some(step_s) = typical_step_s(time) else { return Ok(None) };
        let places: Vec<usize> = time.iter().map(|t| ((t - time[0]) / step_s).round() as usize).collect();
        let on_grid =
            |(t, place): (&f64, &usize)| (t - time[0] - *place as f64 * step_s).abs() < OFF_GRID * step_s;
        let points = places.last().map_or(0, |last| last + 1);
        let rising = places.windows(2).all(|pair| pair[0] < pair[1]);
        if !rising || !time.iter().zip(&places).all(on_grid) || points > SPARSEST * time.len() {
            return Ok(None);
        }
        let slowest = 1.0 / (points as f64 * step_s);
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
    /// The noise as the document declares it, through the converters of `effects`; where it does not, as `residual` (nT, stacked,
    /// with `used` degrees of freedom taken by the fit) shows it.
    pub fn of(
        document: &Document,
        observed: &Observed<'_>,
        effects: &[EffectInstance],
        residual: &[f64],
        used: f64,
    ) -> Result<Self, Error> {
        let declared: Vec<Option<Noise>> =
            observed.channels.iter().map(|channel| declared(document, observed, effects, channel)).collect();
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
            .map(|(channel, noise)| way(observed, channel, noise))
            .collect::<Result<_, Error>>()?;
        let (ways, std_nt) = found.into_iter().unzip();
        Ok(Self { ways, std_nt, known, source: if estimated { "residuals" } else { "declared" } })
    }

    /// Whether it whitens as another does: the same declaration, through the same converters.
    pub fn same(&self, other: &Self) -> bool {
        self.known > 0.0 && self.known == other.known && self.std_nt == other.std_nt
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

/// The declared noise of a channel, its codes included.
fn declared(
    document: &Document,
    observed: &Observed<'_>,
    effects: &[EffectInstance],
    channel: &Channel,
) -> Option<Noise> {
    let run = &observed.runs[channel.run];
    let mut noise = match channel.reader {
        Reader::Scalar => {
            let std = document.facility.as_ref()?.reference_std_nt?;
            Noise { white_rms_nt: Some(std), ..Noise::default() }
        }
        // Of two magnetometers the difference has the noise of both.
        Reader::Sensor(_) if run.differential() => return None,
        Reader::Sensor(axis) => document.instrument.as_ref()?.noise_of(axis)?.clone(),
        Reader::Magnitude => of_magnitude(document, channel)?,
    };
    let codes = code_nt(document, observed, channel).powi(2) / 12.0;
    let white = noise.white_rms_nt.unwrap_or(0.0);
    let variance = match width_nt(effects, channel) {
        Some(width) => about_a_code(white, width),
        None => white * white,
    };
    noise.white_rms_nt = Some((variance + codes).sqrt());
    (noise.white_rms_nt > Some(0.0)).then_some(noise)
}

/// The noise of a corrected vector's length and of the scalar magnetometer beside it: each sensor's counts by its mean share. The scalar
/// magnetometer's is none where the document does not state it.
fn of_magnitude(document: &Document, channel: &Channel) -> Option<Noise> {
    let instrument = document.instrument.as_ref()?;
    let scalar = document.facility.as_ref().and_then(|facility| facility.reference_std_nt).unwrap_or(0.0);
    let mut all = Noise::default();
    let (mut white, mut flicker, mut walk, mut most) = (scalar * scalar, 0.0, 0.0, 0.0);
    for (axis, share) in Axis::ALL.into_iter().zip(mean_shares(channel)) {
        let noise = instrument.noise_of(axis)?;
        let own = share * noise.flicker_nt2_per_hz_at_1hz.unwrap_or(0.0);
        white += share * noise.white_rms_nt.unwrap_or(0.0).powi(2);
        walk += share * noise.random_walk_nt_per_sqrt_s.unwrap_or(0.0).powi(2);
        flicker += own;
        if own > most {
            (most, all.flicker_exponent) = (own, noise.flicker_exponent);
        }
        if noise.relative_std > all.relative_std {
            all.relative_std = noise.relative_std;
        }
    }
    all.white_rms_nt = Some(white.sqrt());
    all.flicker_nt2_per_hz_at_1hz = Some(flicker);
    all.random_walk_nt_per_sqrt_s = Some(walk.sqrt());
    Some(all)
}

/// Mean over the rows of each sensor's squared share in a magnitude.
fn mean_shares(channel: &Channel) -> [f64; 3] {
    let squares = channel.shares.iter().fold(Vector3::zeros(), |sum, share| sum + share.component_mul(share));
    (squares / channel.rows.len().max(1) as f64).into()
}

/// Width of a code of a channel, nT; of a magnitude, of codes that would round as much as those of its sensors together.
fn code_nt(document: &Document, observed: &Observed<'_>, channel: &Channel) -> f64 {
    let Some(instrument) = document.instrument.as_ref() else { return 0.0 };
    let Setting { basic, context } = &observed.runs[channel.run].setting;
    let code = match context.unit {
        Unit::Volt if !observed.runs[channel.run].differential() => instrument.quantisation_v,
        _ => instrument.quantisation_nt,
    };
    let code = code.unwrap_or(0.0);
    match channel.reader {
        Reader::Scalar => 0.0,
        Reader::Sensor(_) => code * channel.to_nt.abs(),
        Reader::Magnitude => {
            let of = |(sensor, share): (&SensorConstants<f64>, f64)| share * sensor.sensitivity.powi(2);
            code * basic.sensors.iter().zip(mean_shares(channel)).map(of).sum::<f64>().sqrt()
        }
    }
}

/// Width of the codes that an effect gives a channel, nT.
fn width_nt(effects: &[EffectInstance], channel: &Channel) -> Option<f64> {
    let Reader::Sensor(axis) = channel.reader else { return None };
    effects
        .iter()
        .find(|effect| effect.kind == Kind::Quantisation && effect.axis == Some(axis))
        .map(|effect| effect.parameters[0])
}

/// Variance of a reading about the code of its field, nT²: noise before the converter takes fields close to an edge to the next code.
///
/// E[(q round(u + n/q) − q round(u))²] over u even in a code: q² E[m² + (2m + 1)(t − m)], t = |n|/q, m = ⌊t⌋. For fine codes it is
/// σ² + q²/6, for coarse ones q σ √(2/π).
fn about_a_code(std: f64, width: f64) -> f64 {
    const STEPS: usize = 2000;
    const FARTHEST: f64 = 8.0;
    let step = FARTHEST / STEPS as f64;
    let (mut sum, mut weights) = (0.0, 0.0);
    for z in (0..STEPS).map(|k| (k as f64 + 0.5) * step) {
        let weight = (-0.5 * z * z).exp();
        let t = z * std / width;
        let m = t.floor();
        sum += weight * (m * m + (2.0 * m + 1.0) * (t - m));
        weights += weight;
    }
    width * width * sum / weights
}

/// 1/(2 u²) for the largest relative uncertainty u that is stated of a declared noise.
fn known_freedom(declared: &[Option<Noise>]) -> f64 {
    if declared.iter().any(Option::is_none) {
        return 0.0;
    }
    let relative = declared.iter().flatten().filter_map(|noise| noise.relative_std).fold(0.0, f64::max);
    if relative > 0.0 { 0.5 / (relative * relative) } else { f64::INFINITY }
}

/// Noise as a residual shows it: the spectrum of an even series, else white noise of each kind of channel.
fn estimate(
    document: &Document,
    observed: &Observed<'_>,
    residual: &[f64],
    used: f64,
) -> Result<Vec<Noise>, Error> {
    let share = (1.0 - used / observed.rows as f64).max(0.05);
    let mut sums: BTreeMap<String, (f64, usize)> = BTreeMap::new();
    let (mut whole, mut readings) = (0.0, 0);
    for channel in &observed.channels {
        let sum: f64 = residual[channel.range()].iter().map(|r| r * r).sum();
        let entry = sums.entry(kind(channel)).or_default();
        *entry = (entry.0 + sum, entry.1 + channel.rows.len());
        (whole, readings) = (whole + sum, readings + channel.rows.len());
    }
    let alone = sums.values().all(|(_, count)| *count >= ALONE_FROM);
    observed
        .channels
        .iter()
        .map(|channel| {
            let (sum, count) = if alone { sums[&kind(channel)] } else { (whole, readings) };
            let least = (code_nt(document, observed, channel).powi(2) / 12.0).max(f64::MIN_POSITIVE.sqrt());
            let variance = (sum / (count as f64 * share)).max(least);
            let white = Noise { white_rms_nt: Some(variance.sqrt()), ..Noise::default() };
            let step_s = observed.times(channel).and_then(|time| even_step_s(&time));
            let Some(step_s) = step_s.filter(|_| channel.rows.len() >= SPECTRUM_FROM) else {
                return Ok(white);
            };
            let spectrum = periodogram(&residual[channel.range()], step_s);
            let fit = spectrum.and_then(|spectrum| whittle::fit_with(&[spectrum], White::PerReading));
            let Ok(fit) = fit else { return Ok(white) };
            if fit.amplitude.value <= 0.0 {
                return Ok(white);
            }
            Ok(Noise {
                white_rms_nt: Some(fit.white_variances[0].max(1e-6 * variance).sqrt()),
                flicker_nt2_per_hz_at_1hz: Some(fit.amplitude.value),
                flicker_exponent: Some(fit.exponent.value.min(2.0)),
                ..Noise::default()
            })
        })
        .collect()
}

/// Channels that share their white noise.
fn kind(channel: &Channel) -> String {
    match channel.reader {
        Reader::Scalar => "scalar".into(),
        Reader::Magnitude => "magnitude".into(),
        Reader::Sensor(axis) => axis.to_string(),
    }
}

fn way(observed: &Observed<'_>, channel: &Channel, noise: &Noise) -> Result<(Way, f64), Error> {
    let rows = channel.rows.len();
    let memory = noise.flicker_nt2_per_hz_at_1hz.unwrap_or(0.0) > 0.0
        || noise.random_walk_nt_per_sqrt_s.unwrap_or(0.0) > 0.0;
    let time = observed.times(channel).filter(|_| memory);
    let white = noise.white_rms_nt.unwrap_or(0.0);
    let Some(time) = time else { return Ok((Way::White(white), white)) };
    if rows > LONGEST {
        let Some(grid) = Grid::of(noise, &time)? else {
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
    let matrix = Mat::from_fn(rows, rows, |i, j| covariance[i * rows + j]);
    Ok((Way::Whole(Arc::new(Whitening::of(&[matrix])?)), mean.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_through_a_converter_has_both_limits() {
        let fine = about_a_code(1.0, 0.01);
        assert!((fine - (1.0 + 0.01 * 0.01 / 6.0)).abs() < 1e-4, "{fine}");
        let coarse = about_a_code(1.0, 100.0) / (100.0 * (2.0 / std::f64::consts::PI).sqrt());
        assert!((coarse - 1.0).abs() < 1e-4, "{coarse}");
    }
}
