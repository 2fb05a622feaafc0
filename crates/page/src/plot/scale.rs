//! From values to places on the drawing.

use super::ticks::{self, Tick};
use crate::number;

/// A scale: the values from `low` to `high` lie between two places.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Value at the first place.
    pub low: f64,
    /// Value at the second place.
    pub high: f64,
    /// The places, in the drawing's units.
    pub places: [f64; 2],
    log: bool,
}

impl Scale {
    /// The scale that holds the values, with a little air; None without a value that it can hold, or where
    /// they are too far apart for a number.
    pub fn over(values: impl Iterator<Item = f64>, log: bool) -> Option<Self> {
        let [low, high] = number::ends(values.filter(|value| !log || *value > 0.0))?;
        let [low, high] = if log { [low.log10(), high.log10()] } else { [low, high] };
        let span = high - low;
        if !span.is_finite() {
            return None;
        }
        let air = if span > 1e-12 * high.abs().max(low.abs()) { 0.05 * span } else { air_around(high, log) };
        let [low, high] = [low - air, high + air];
        let [low, high] = if log { [10f64.powf(low), 10f64.powf(high)] } else { [low, high] };
        Some(Self { low, high, places: [0.0, 1.0], log })
    }

    /// The same between these places.
    pub fn at(self, places: [f64; 2]) -> Self {
        Self { places, ..self }
    }

    /// Where a value lies; None where there is no place for it.
    pub fn place(&self, value: f64) -> Option<f64> {
        if !value.is_finite() || (self.log && value <= 0.0) {
            return None;
        }
        let share = if self.log {
            (value / self.low).log10() / (self.high / self.low).log10()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        Some(self.places[0] + share * (self.places[1] - self.places[0]))
    }

    /// The marks, about `wanted` of them.
    pub fn ticks(&self, wanted: usize) -> Vec<Tick> {
        if self.log {
            ticks::decades(self.low, self.high, wanted)
        } else {
            ticks::linear(self.low, self.high, wanted)
        }
    }
}

/// Room around a single value.
fn air_around(value: f64, log: bool) -> f64 {
    if log {
        0.5
    } else if value == 0.0 {
        1.0
    } else {
        0.1 * value.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_and_logarithmic() {
        let linear = Scale::over([0.0, f64::NAN, 10.0].into_iter(), false).expect("values").at([100.0, 0.0]);
        assert_eq!((linear.low, linear.high), (-0.5, 10.5));
        assert_eq!(linear.place(5.0), Some(50.0));
        assert_eq!(linear.place(f64::INFINITY), None);
        let log = Scale::over([-1.0, 0.0, 1.0, 100.0].into_iter(), true).expect("values").at([0.0, 100.0]);
        assert!((log.place(10.0).expect("a place") - 50.0).abs() < 1e-9);
        assert_eq!(log.place(0.0), None);
    }

    #[test]
    fn one_value_has_room_and_none_has_no_scale() {
        let single = Scale::over([6400.0].into_iter(), false).expect("a value");
        assert!(single.low < 6400.0 && single.high > 6400.0);
        assert!(Scale::over([f64::NAN].into_iter(), false).is_none());
        assert!(Scale::over([-1.0].into_iter(), true).is_none());
    }
}
