use estimate::even::{NEAR, Places};
use serde::{Deserialize, Serialize};

use super::error::Error;

/// A time may be so far from its place, in steps.
const OFF: f64 = 0.4;
/// Digits of a step, or of a rate, that is found rather than stated.
const DIGITS: i32 = 6;

/// The places at which samples stand: (i + φ) Δt from time 0, i whole, φ = 0 or 1/2.
///
/// So the place of a sample does not depend on where its piece begins. Loggers that sample off the whole step
/// are within a quarter of one of the two grids, and their jitter has room.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object")]
pub struct Grid {
    /// Δt, s.
    pub step_s: f64,
    /// Whether φ is 1/2.
    pub half: bool,
}

impl Grid {
    /// The grid of a step on which a time stands best; [`Error::Step`] where it is none.
    pub fn of(step_s: f64, time_s: f64) -> Result<Self, Error> {
        if !(step_s > 0.0 && step_s.is_finite()) {
            return Err(Error::Step(step_s));
        }
        let place = time_s / step_s;
        Ok(Self { step_s, half: (place - place.round()).abs() > 0.25 })
    }

    /// The grid of times, of which some may be missing: the step of fewest digits (as a step or as a rate, up
    /// to six) on which all stand; else [`Error::NoStep`].
    pub fn found(times: &[f64]) -> Result<Self, Error> {
        let none = Error::NoStep { rows: times.len() };
        let Some(even) = Places::of(times).filter(|places| places.even(NEAR)) else { return Err(none) };
        let (places, mean) = ((even.count() - 1) as f64, even.step_s);
        let digits = |value: f64, digits: i32| {
            let unit = 10_f64.powi(value.abs().log10().floor() as i32 + 1 - digits);
            if unit >= 1.0 {
                (value / unit).round() * unit
            } else {
                (value * (1.0 / unit).round()).round() / (1.0 / unit).round()
            }
        };
        (1..=DIGITS)
            .flat_map(|count| [digits(mean, count), 1.0 / digits(1.0 / mean, count)])
            .filter(|step| step.is_finite() && *step > 0.0)
            .filter_map(|step| Self::of(step, times[0]).ok())
            .find(|grid| {
                let place = |time: f64| grid.place(time).ok();
                let near = |time: f64| {
                    place(time).is_some_and(|at| (time - grid.time_s(at)).abs() <= NEAR * grid.step_s)
                };
                times.iter().all(|time| near(*time))
                    && place(times[times.len() - 1])
                        .zip(place(times[0]))
                        .is_some_and(|(last, first)| (last - first) as f64 == places)
            })
            .ok_or(none)
    }

    fn phase(&self) -> f64 {
        if self.half { 0.5 } else { 0.0 }
    }

    /// Whether a time stands on a place.
    #[inline]
    pub fn holds(&self, time_s: f64, place: i64) -> bool {
        (time_s / self.step_s - self.phase() - place as f64).abs() <= OFF
    }

    /// The number of a time's place, or how far the time is from it in steps.
    #[inline]
    pub fn place(&self, time_s: f64) -> Result<i64, f64> {
        let at = time_s / self.step_s - self.phase();
        let place = at.round();
        let off = (at - place).abs();
        if off <= OFF { Ok(place as i64) } else { Err(off) }
    }

    /// The time of a place, s.
    pub fn time_s(&self, place: i64) -> f64 {
        (place as f64 + self.phase()) * self.step_s
    }

    /// That pieces on this grid and on another cannot be joined.
    pub(super) fn unlike(self, other: Self) -> Error {
        let [first, second] = [self, other].map(|grid| format!("every {grid} s"));
        let expected = "the same step in all; state it when writing them (--step-s)";
        Error::Piece(partial::Error::Unlike { first, second, expected })
    }
}

impl std::fmt::Display for Grid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}", self.step_s, if self.half { " (between whole steps)" } else { "" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_found_and_places_do_not_depend_on_the_piece() {
        for step in [1.0, 60.0, 0.1, 0.01, 1.0 / 128.0, 1.0 / 3.0, 86_400.0, 0.000_25, 1.0 / 16.5] {
            for from in [0_u32, 17, 1_700_000_000] {
                let times: Vec<f64> =
                    (0..3000).filter(|i| i % 7 != 3).map(|i| f64::from(from) + f64::from(i) * step).collect();
                let grid = Grid::found(&times).expect("a grid");
                assert_eq!(grid.step_s, step, "{from}");
                let place = grid.place(times[0]).expect("on the grid");
                assert!((grid.time_s(place) - times[0]).abs() <= 0.4 * step);
            }
        }
        let jitter: Vec<f64> =
            (0..500).map(|i| f64::from(i) + 0.47 + 0.1 * (f64::from(i) * 7.3).sin()).collect();
        assert_eq!(Grid::found(&jitter), Ok(Grid { step_s: 1.0, half: true }));
        assert!(Grid::found(&[1.0]).is_err());
        assert!(Grid::found(&[0.0, 1.0, 2.5, 4.0, 4.3, 7.1]).is_err());
        assert!(Grid::of(-1.0, 0.0).is_err());
    }
}
