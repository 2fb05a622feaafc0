//! From values to places on the drawing; where an axis has its marks, and what stands at them.

use common::time::Start;

use super::drawn::Timeline;
use crate::page::number;

const DAY_S: f64 = 86_400.0;
/// Steps between marks within a day, s.
const CLOCK_S: [f64; 18] = [
    1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1800.0, 3600.0, 7200.0, 10_800.0,
    21_600.0, 43_200.0, DAY_S,
];

/// A scale: the values from `low` to `high` lie between two places.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    pub low: f64,
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
        let air = match span > 1e-12 * high.abs().max(low.abs()) {
            true => 0.05 * span,
            // Room around a single value.
            false if log => 0.5,
            false if high == 0.0 => 1.0,
            false => 0.1 * high.abs(),
        };
        let [low, high] = [low - air, high + air];
        let [low, high] = if log { [10f64.powf(low), 10f64.powf(high)] } else { [low, high] };
        Some(Self { low, high, places: [0.0, 1.0], log })
    }

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

    pub fn ticks(&self, wanted: usize) -> Vec<Tick> {
        let marks = if self.log { decades } else { linear };
        marks(self.low, self.high, wanted)
    }

    /// Marks at times of day and dates, as the script has them; None where no date is known or seconds are too long.
    pub fn moments(&self, time: &Timeline, wanted: usize) -> Option<Vec<Tick>> {
        let epoch = time.epoch_s?;
        let [low, high] = [self.low, self.high].map(|value| epoch + value * time.unit_s);
        let rough = 0.7 * (high - low) / wanted as f64;
        let days = || DAY_S * step_near(rough / DAY_S).1.max(1.0);
        let step = CLOCK_S.into_iter().find(|step| *step >= rough).unwrap_or_else(days);
        let tick = |moment: f64| {
            let text = moment_text(moment)?;
            let label = if moment % DAY_S == 0.0 {
                &text[..10]
            } else {
                &text[11..if step < 60.0 { 19 } else { 16 }]
            };
            Some(Tick { at: (moment - epoch) / time.unit_s, label: label.into() })
        };
        let [first, last] = [(low / step).ceil() as i64, (high / step).floor() as i64];
        (rough >= 0.5).then(|| (first..=last).map(|n| tick(n as f64 * step)).collect())?
    }
}

/// `2026-11-30T09:30:00Z`.
pub fn moment_text(unix_s: f64) -> Option<String> {
    Start { unix_s: unix_s.floor(), offset_s: 0.0 }.text()
}

#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    pub at: f64,
    /// What stands there; empty for a minor mark.
    pub label: String,
}

/// Power of ten and size of a step of 1, 2 or 5.
fn step_near(rough: f64) -> (i32, f64) {
    let power = rough.log10().floor() as i32;
    let (factor, power) = match rough / 10f64.powi(power) {
        ratio if ratio <= 1.5 => (1.0, power),
        ratio if ratio <= 3.2 => (2.0, power),
        ratio if ratio <= 7.0 => (5.0, power),
        _ => (1.0, power + 1),
    };
    (power, factor * 10f64.powi(power))
}

/// Marks at multiples of 1, 2 or 5 times a power of ten, about `wanted` of them.
fn linear(low: f64, high: f64, wanted: usize) -> Vec<Tick> {
    let (power, step) = step_near((high - low) / wanted as f64);
    let [first, last] = [(low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64];
    let at = (first..=last).map(|n| n as f64 * step);
    let largest = low.abs().max(high.abs());
    let label = |at: f64| {
        if largest < 1e6 && power >= -4 {
            number::fixed(at, (-power).max(0))
        } else {
            number::significant(at, (largest / step).log10().max(0.0).ceil() as usize + 1)
        }
    };
    at.map(|at| Tick { at, label: label(at) }).collect()
}

/// Marks at powers of ten, every second or third of them where there are many; within two decades 2 and 5
/// stand as well.
fn decades(low: f64, high: f64, wanted: usize) -> Vec<Tick> {
    let [first, last] = [low.log10().floor() as i32, high.log10().ceil() as i32];
    let inside = |at: f64| at >= low * (1.0 - 1e-9) && at <= high * (1.0 + 1e-9);
    let span = (high / low).log10();
    let stride = (span / wanted as f64).ceil().max(1.0) as i32;
    let mut ticks = Vec::new();
    for power in first..=last {
        let unit = 10f64.powi(power);
        for factor in 1..10 {
            let at = f64::from(factor) * unit;
            let labelled = match factor {
                1 => power.rem_euclid(stride) == 0,
                2 | 5 => span < 2.0,
                _ => span < 0.7,
            };
            let label = match (labelled, span < 2.0) {
                (false, _) => String::new(),
                (true, true) => number::significant(at, 2),
                (true, false) => format!("10{}", number::superscript(power)),
            };
            if inside(at) && (labelled || stride == 1) {
                ticks.push(Tick { at, label });
            }
        }
    }
    ticks
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
        // One value has room, and none has no scale.
        let single = Scale::over([6400.0].into_iter(), false).expect("a value");
        assert!(single.low < 6400.0 && single.high > 6400.0);
        assert!(Scale::over([f64::NAN].into_iter(), false).is_none());
        assert!(Scale::over([-1.0].into_iter(), true).is_none());
    }

    #[test]
    fn dates_and_times_of_day() {
        let [recording, group] = [String::new(), String::new()];
        let hour = Timeline { recording, group, unit_s: 3600.0, epoch_s: Some(86_400.0) };
        let time = |unit_s: f64| Timeline { unit_s, ..hour.clone() };
        let scale = |high: f64| Scale { low: 0.0, high, places: [0.0, 1.0], log: false };
        let hours = scale(26.0).moments(&time(3600.0), 4).expect("dated");
        assert_eq!(labels(&hours), ["1970-01-02", "06:00", "12:00", "18:00", "1970-01-03"]);
        assert_eq!(hours[1].at, 6.0);
        let days = scale(10.0).moments(&time(86_400.0), 3).expect("dated");
        assert_eq!(labels(&days)[..2], ["1970-01-03", "1970-01-05"]);
        assert_eq!(scale(1.0).moments(&time(1.0), 4), None);
    }

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().map(|tick| tick.label.as_str()).filter(|label| !label.is_empty()).collect()
    }

    #[test]
    fn one_two_five() {
        assert_eq!(labels(&linear(-0.13, 0.21, 4)), ["−0.1", "0.0", "0.1", "0.2"]);
        assert_eq!(labels(&linear(-52000.0, 52000.0, 5)), ["−40000", "−20000", "0", "20000", "40000"]);
        assert_eq!(labels(&linear(6401.19, 6401.26, 4)), ["6401.20", "6401.22", "6401.24", "6401.26"]);
        assert_eq!(labels(&linear(0.0, 3e-6, 3)), ["0", "1·10⁻⁶", "2·10⁻⁶", "3·10⁻⁶"]);
    }

    #[test]
    fn powers_of_ten() {
        assert_eq!(labels(&decades(2e-4, 50.0, 7)), ["10⁻³", "10⁻²", "10⁻¹", "10⁰", "10¹"]);
        assert_eq!(labels(&decades(1e-5, 1e6, 5)), ["10⁻³", "10⁰", "10³", "10⁶"]);
        assert_eq!(labels(&decades(0.5, 20.0, 5)), ["0.5", "1", "2", "5", "10", "20"]);
        assert_eq!(decades(0.01, 1.0e2, 5).len(), 5 + 32);
    }
}
