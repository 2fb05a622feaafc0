//! Noise as an instrument declares it ([`common::Noise`]), made from a seed.
//!
//! Every channel draws from a stream of its own name, so that a channel more changes no other, and so does
//! each kind of noise within it. The same seed and name give the same numbers on any number of threads.
//!
//! [`Whitening`] turns readings with such noise into ones with white noise of variance one.

mod backward;
mod covariance;
mod filter;
mod flicker;
mod least_squares;
mod level;
mod means;
mod power_law;
mod stream;
mod sums;
mod whitening;

pub use covariance::covariance;
pub use flicker::{Process, SLOWEST};
pub use means::{covariance_of_means, mean_variance};
pub use power_law::{power_law, random_walk};
pub use stream::Stream;
pub use whitening::Whitening;

use common::Noise;
use common::number::significant;
use std::borrow::Cow;
use thiserror::Error;

/// Steps within this part of the typical one count as equal to it.
const EVEN: f64 = 1e-3;
/// Points of the grid on which noise with memory is made, at most.
const MOST_POINTS: f64 = 1e8;

/// Why noise cannot be made, or whitened.
#[derive(Debug, Error, PartialEq)]
pub enum NoiseError {
    /// The exponent is none.
    #[error("flicker noise with the exponent {0}")]
    Exponent(f64),
    /// A row has no time, or one before that of the row above.
    #[error(
        "no time in row {0} of time_s, or one before that of the row above, where noise with memory needs times in order"
    )]
    Disorder(usize),
    /// The times span more steps than fit, or none.
    #[error(
        "times that span {} s in steps of {} s, where noise with memory needs at most {} of them",
        significant(*.0, 2),
        significant(*.1, 2),
        significant(MOST_POINTS, 2)
    )]
    Length(f64, f64),
    /// No noise at all is declared.
    #[error("a noise of zero, by which no reading can be weighed")]
    Nothing,
}

/// The declared noise of one channel, nT: white + flicker + random walk.
///
/// Flicker noise and the random walk need the times; without them, or with one row, only white noise is made.
/// At uneven times flicker noise is made on an even grid of the median step and read off by straight lines.
pub fn series(
    noise: &Noise,
    seed: u64,
    channel: &str,
    rows: usize,
    time_s: Option<&[f64]>,
) -> Result<Vec<f64>, NoiseError> {
    let white = noise.white_rms_nt.unwrap_or(0.0);
    let mut stream = Stream::new(seed, channel);
    let mut readings: Vec<f64> = (0..rows).map(|_| stream.normal() * white).collect();
    let Some(time) = time_s.filter(|time| time.len() == rows && rows > 1) else { return Ok(readings) };
    if let Some((amplitude, exponent)) = flicker_of(noise)? {
        let mut stream = Stream::new(seed, &format!("{channel}/flicker"));
        let grid = Grid::of(time)?;
        let flicker = power_law(&mut stream, grid.points, grid.step_s, amplitude, exponent);
        for (reading, flicker) in readings.iter_mut().zip(grid.read(time, &flicker).iter()) {
            *reading += flicker;
        }
    }
    let rate = noise.random_walk_nt_per_sqrt_s.unwrap_or(0.0);
    if rate > 0.0 {
        let mut stream = Stream::new(seed, &format!("{channel}/walk"));
        for (reading, walk) in readings.iter_mut().zip(random_walk(&mut stream, time, rate)) {
            *reading += walk;
        }
    }
    Ok(readings)
}

/// Amplitude (nT²/Hz at 1 Hz) and exponent of the flicker noise, where there is any.
fn flicker_of(noise: &Noise) -> Result<Option<(f64, f64)>, NoiseError> {
    let Some(amplitude) = noise.flicker_nt2_per_hz_at_1hz.filter(|amplitude| *amplitude > 0.0) else {
        return Ok(None);
    };
    match noise.flicker_exponent.unwrap_or(1.0) {
        exponent @ 0.0..=2.0 => Ok(Some((amplitude, exponent))),
        other => Err(NoiseError::Exponent(other)),
    }
}

/// Rounds to whole codes of a width; a width of zero rounds nothing.
pub fn quantise(readings: &mut [f64], width: f64) {
    if width > 0.0 {
        readings.iter_mut().for_each(|reading| *reading = (*reading / width).round() * width);
    }
}

/// The steps between times in order, and the typical one: the median of those above zero (zero where there
/// are none). Steps that count as equal to the typical one are set to it.
fn steps(time_s: &[f64]) -> Result<(Vec<f64>, f64), NoiseError> {
    let ordered = |row: &usize| time_s[*row].is_finite() && (*row == 0 || time_s[*row] >= time_s[*row - 1]);
    if let Some(row) = (0..time_s.len()).find(|row| !ordered(row)) {
        return Err(NoiseError::Disorder(row));
    }
    let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut positive: Vec<f64> = steps.iter().copied().filter(|step| *step > 0.0).collect();
    let middle = positive.len() / 2;
    let typical =
        if positive.is_empty() { 0.0 } else { *positive.select_nth_unstable_by(middle, f64::total_cmp).1 };
    for step in steps.iter_mut().filter(|step| (**step - typical).abs() <= EVEN * typical) {
        *step = typical;
    }
    Ok((steps, typical))
}

/// An even grid over times that may be uneven.
struct Grid {
    points: usize,
    step_s: f64,
    even: bool,
}

impl Grid {
    fn of(time: &[f64]) -> Result<Self, NoiseError> {
        let (_, step_s) = steps(time)?;
        let length_s = time[time.len() - 1] - time[0];
        let mean = length_s / (time.len() - 1) as f64;
        // Times that are rounded or jitter by less than a quarter of a step are even.
        let even = |(row, t): (usize, &f64)| (t - time[0] - row as f64 * mean).abs() <= mean / 4.0;
        if mean > 0.0 && time.iter().enumerate().all(even) {
            return Ok(Self { points: time.len(), step_s: mean, even: true });
        }
        let points = length_s / step_s + 2.0;
        if points.is_finite() && points <= MOST_POINTS {
            Ok(Self { points: points as usize, step_s, even: false })
        } else {
            Err(NoiseError::Length(length_s, step_s))
        }
    }

    /// The values of a series on the grid at the times.
    fn read<'a>(&self, time: &[f64], series: &'a [f64]) -> Cow<'a, [f64]> {
        if self.even {
            return series.into();
        }
        time.iter()
            .enumerate()
            .map(|(row, t)| {
                let (point, share) = self.place(row, *t, time[0]);
                series[point] + (series[point + 1] - series[point]) * share
            })
            .collect()
    }

    /// The point of the grid before a time, and the share of the step from it that has passed.
    fn place(&self, row: usize, time_s: f64, first_s: f64) -> (usize, f64) {
        if self.even {
            return (row, 0.0);
        }
        let at = (time_s - first_s) / self.step_s;
        let point = (at as usize).min(self.points - 2);
        (point, at - point as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_whole() {
        let mut readings = [0.3, -0.8, 7.49];
        quantise(&mut readings, 0.5);
        assert_eq!(readings, [0.5, -1.0, 7.5]);
        quantise(&mut readings, 0.0);
        assert_eq!(readings, [0.5, -1.0, 7.5]);
    }

    #[test]
    fn uneven_times_read_the_grid() {
        let time = [0.0, 1.0, 2.0, 3.5, 4.0, 5.0];
        let grid = Grid::of(&time).expect("a grid");
        assert_eq!((grid.points, grid.step_s), (7, 1.0));
        let ramp: Vec<f64> = (0..7).map(f64::from).collect();
        assert_eq!(grid.read(&time, &ramp).as_ref(), time);
        let far = [0.0, 1e-6, 2e-6, 1e6];
        assert!(matches!(Grid::of(&far), Err(NoiseError::Length(..))));
    }

    #[test]
    fn each_kind_of_noise_has_its_own_stream() {
        let time: Vec<f64> = (0..64).map(f64::from).collect();
        let make = |json: &str| {
            let noise: Noise = serde_json::from_str(json).expect("a noise");
            series(&noise, 7, "run/sensor_x_v", 64, Some(&time)).expect("noise")
        };
        let white = make(r#"{"white_rms_nt": 2.0}"#);
        let flicker = make(r#"{"flicker_nt2_per_hz_at_1hz": 0.3, "flicker_exponent": 1.2}"#);
        let walk = make(r#"{"random_walk_nt_per_sqrt_s": 0.1}"#);
        let all = make(
            r#"{"white_rms_nt": 2.0, "flicker_nt2_per_hz_at_1hz": 0.3, "flicker_exponent": 1.2, "random_walk_nt_per_sqrt_s": 0.1}"#,
        );
        for row in 0..64 {
            assert!((all[row] - white[row] - flicker[row] - walk[row]).abs() < 1e-12);
        }
        let steep: Noise =
            serde_json::from_str(r#"{"flicker_nt2_per_hz_at_1hz": 1.0, "flicker_exponent": 2.5}"#)
                .expect("a noise");
        assert_eq!(series(&steep, 1, "x", 64, Some(&time)), Err(NoiseError::Exponent(2.5)));
    }
}
