//! Where an axis has its marks, and what stands at them.

use crate::number;

/// A mark of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Where.
    pub at: f64,
    /// What stands there; empty for a minor mark.
    pub label: String,
}

/// Marks at multiples of 1, 2 or 5 times a power of ten, about `wanted` of them.
pub fn linear(low: f64, high: f64, wanted: usize) -> Vec<Tick> {
    let rough = (high - low) / wanted as f64;
    let power = rough.log10().floor() as i32;
    let unit = 10f64.powi(power);
    let (factor, power) = match rough / unit {
        ratio if ratio <= 1.5 => (1.0, power),
        ratio if ratio <= 3.2 => (2.0, power),
        ratio if ratio <= 7.0 => (5.0, power),
        _ => (1.0, power + 1),
    };
    let step = factor * 10f64.powi(power);
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
pub fn decades(low: f64, high: f64, wanted: usize) -> Vec<Tick> {
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
        let minor = decades(0.01, 1.0e2, 5).len() - 5;
        assert_eq!(minor, 32);
    }
}
