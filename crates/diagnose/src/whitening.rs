//! The noise of each channel, and with it the way to independent errors of variance one.

mod declared;
mod restricted;

use common::Noise;
use estimate::events::correlate;
use estimate::stats::median;
use noise::{NoiseError, Whitening};
use rayon::prelude::*;

use crate::Error;
use crate::channel::Channel;
use crate::model::State;
use crate::observed::Observed;
use crate::stacked::Stacked;
pub use declared::code_nt;
pub use declared::known_freedom;
use declared::{declared, estimate};

/// Periods of declared flicker noise that count, in lengths of the campaign.
const OLDEST: f64 = 8.0;
/// Standard deviation of normal numbers over the median of their sizes.
const NORMAL: f64 = 1.4826;
/// Columns that are whitened in one pass.
const BATCH: usize = 32;

/// Standard deviation of white noise as neighbouring readings differ: by the median of the distances.
pub fn neighbours_std(residual: &[f64]) -> f64 {
    let apart: Vec<f64> = residual.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    NORMAL * median(&apart) * std::f64::consts::FRAC_1_SQRT_2
}

#[derive(Clone, Debug)]
pub struct NoiseModel {
    whitenings: Vec<Whitening>,
    /// Standard deviation of a reading of each channel about its mean, nT.
    pub std_nt: Vec<f64>,
    /// Degrees of freedom with which the size of the noise is known beforehand: infinite where it is
    /// declared, zero where it is estimated from the residual.
    pub known: f64,
}

impl NoiseModel {
    /// The noise as it is declared, through the converters of a state; else white as `residual` (nT) shows it.
    pub fn of(observed: &Observed<'_>, state: &State, residual: &[f64]) -> Result<Self, Error> {
        let declared: Vec<Option<Noise>> =
            observed.channels.iter().map(|channel| declared(observed, state, channel)).collect();
        let known = known_freedom(&declared);
        if known == 0.0 {
            return Self::estimated(observed, residual);
        }
        let noises: Vec<Noise> = declared.into_iter().flatten().collect();
        Self::with(observed, &noises, known)
    }

    /// White noise as a residual shows it, whatever is declared.
    pub fn estimated(observed: &Observed<'_>, residual: &[f64]) -> Result<Self, Error> {
        Self::with(observed, &estimate(observed, residual), 0.0)
    }

    /// Noise with memory as a residual shows it beside fitted columns (nT, stacked), whatever is declared.
    pub fn restricted(
        observed: &Observed<'_>,
        columns: &[Vec<f64>],
        residual: &[f64],
    ) -> Result<Self, Error> {
        Self::with(observed, &restricted::restricted(observed, columns, residual)?, 0.0)
    }

    fn with(observed: &Observed<'_>, noises: &[Noise], known: f64) -> Result<Self, Error> {
        let channels = observed.channels.par_iter().zip(noises);
        let whitenings = channels.map(|(channel, noise)| whitening(observed, channel, noise, known > 0.0));
        let whitenings: Vec<Whitening> = whitenings.collect::<Result<_, Error>>()?;
        let variance = |own: &Whitening| if own.is_white() { own.white_nt2() } else { own.variance_nt2() };
        let std_nt = whitenings.iter().map(|whitening| variance(whitening).sqrt()).collect();
        Ok(Self { whitenings, std_nt, known })
    }

    /// White noise of each channel as neighbouring readings of a residual differ: by the median of the distances.
    pub fn white(observed: &Observed<'_>, residual: &[f64]) -> Result<Self, Error> {
        let of = |channel: &Channel| {
            let values = &residual[channel.range()];
            let apart: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
            let most =
                apart.iter().map(|value| value * value).sum::<f64>() / (2.0 * apart.len().max(1) as f64);
            let usual = neighbours_std(values);
            let least = code_nt(observed, channel) / 12.0_f64.sqrt();
            // Of coarse codes most distances are zero.
            let std =
                if usual > least { usual } else { most.sqrt().max(least).max(f64::MIN_POSITIVE.sqrt()) };
            Noise { white_rms_nt: Some(std), ..Noise::default() }
        };
        Self::with(observed, &observed.channels.iter().map(of).collect::<Vec<_>>(), 0.0)
    }

    /// ln of the determinant of the covariance of all readings.
    pub fn log_determinant(&self) -> f64 {
        self.whitenings.iter().map(Whitening::log_determinant).sum()
    }

    pub fn same(&self, other: &Self) -> bool {
        self.whitenings.iter().zip(&other.whitenings).all(|(own, other)| own.same(other))
    }

    pub fn remembers(&self, channel: usize) -> bool {
        !self.whitenings[channel].is_white()
    }

    /// Mean variance of a reading over the channels, nT².
    pub fn variance(&self) -> f64 {
        self.std_nt.iter().map(|std| std * std).sum::<f64>() / self.std_nt.len().max(1) as f64
    }

    /// Columns whitened, each by the noise of its channels, on all threads.
    pub fn whitened(&self, columns: &[Stacked]) -> Vec<Stacked> {
        let parts: Vec<Vec<Option<Vec<f64>>>> = (0..self.whitenings.len())
            .into_par_iter()
            .map(|channel| {
                let mut white: Vec<Option<Vec<f64>>> =
                    columns.iter().map(|column| column.part(channel).map(<[f64]>::to_vec)).collect();
                let mut there: Vec<&mut Vec<f64>> = white.iter_mut().flatten().collect();
                there.par_chunks_mut(BATCH).for_each(|batch| self.whitenings[channel].whiten_all(batch));
                white
            })
            .collect();
        let mut parts: Vec<_> = parts.into_iter().map(Vec::into_iter).collect();
        let one = |_: &Stacked| Stacked::new(parts.iter_mut().map(|part| part.next().flatten()).collect());
        columns.iter().map(one).collect()
    }

    pub fn whiten(&self, observed: &Observed<'_>, series: &[f64]) -> Vec<f64> {
        let channels = observed.channels.iter().enumerate();
        channels.flat_map(|(k, channel)| self.whitenings[k].whiten(&series[channel.range()])).collect()
    }

    /// Stacked columns whitened, on all threads.
    pub fn whiten_all(&self, observed: &Observed<'_>, columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let stacked: Vec<Stacked> = columns.iter().map(|column| Stacked::of(observed, column)).collect();
        self.whitened(&stacked).iter().map(|column| column.dense(observed)).collect()
    }

    /// What a departure of one nT in the middle of a channel is whitened to, from its row on.
    pub fn response(&self, channel: usize) -> Vec<f64> {
        let whitening = &self.whitenings[channel];
        if whitening.is_white() { vec![1.0 / self.std_nt[channel]] } else { whitening.response() }
    }

    /// A whitened series through that response, backwards: what a departure in each row has to do with it.
    pub fn filtered(&self, channel: usize, white: &[f64]) -> Vec<f64> {
        correlate(white, &self.response(channel))
    }
}

/// The whitening of a channel. A declaration ends at one over the recording's length, but such noise did not
/// begin with it: levels and trends of a recording are part of it, and what is slower than the whole campaign
/// is one level throughout. Where the noise was estimated from a residual, nothing is known of it below one
/// over the recording's length: there it is level, and a recording's mean is known as well as if its readings
/// were independent. Otherwise steep noise would take the level for noise, and with it the calibration that
/// was to explain it. From one recording to the next flicker noise goes on: levels differ by as much as noise whose
/// density grows no faster than 1/f from there on down to one over the campaign's length.
fn whitening(
    observed: &Observed<'_>,
    channel: &Channel,
    noise: &Noise,
    declared: bool,
) -> Result<Whitening, Error> {
    let time = observed.times(channel);
    let rows = channel.rows.len();
    let length = time.as_ref().map_or(1.0, |time| time[time.len() - 1] - time[0]);
    let campaign = observed.span().map_or(0.0, |(_, length)| length);
    let oldest = if declared { length.max(OLDEST * campaign) } else { length * noise::SLOWEST };
    let refused = |error: NoiseError| {
        Error::document(
            observed.runs[channel.run].path.clone(),
            error.to_string(),
            "a noise that is declared with an exponent from 0 to 2, and times in order",
        )
    };
    let whitening = Whitening::of(noise, time.as_deref(), rows, oldest).map_err(refused)?;
    if declared || whitening.is_white() {
        return Ok(whitening);
    }
    let density = noise.flicker_nt2_per_hz_at_1hz.unwrap_or(0.0);
    let slower = density
        * length.powf(noise.flicker_exponent.unwrap_or(1.0) - 1.0)
        * (campaign / length).ln().max(0.0);
    let variance = whitening.variance_nt2() / rows as f64 + slower;
    Ok(whitening.with_level(variance.sqrt()))
}
