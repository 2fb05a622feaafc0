//! Smooth functions of a covariate and of time, order by order.

use std::f64::consts::PI;

use crate::channel::Run;

/// The lowest and the highest of values, those that are no number left out; None where they do not differ.
pub fn range<'v>(values: impl Iterator<Item = &'v f64>) -> Option<[f64; 2]> {
    let known = values.filter(|value| value.is_finite());
    let (low, high) = known.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    (high.partial_cmp(&low) == Some(std::cmp::Ordering::Greater)).then_some([low, high])
}

/// A value by its place in a range, from −1 to 1; None where there is none.
pub fn place(value: f64, [low, high]: [f64; 2]) -> Option<f64> {
    let x = (2.0 * value - low - high) / (high - low);
    x.is_finite().then(|| x.clamp(-1.0, 1.0))
}

/// The Chebyshev polynomial of an order, from the first on, over a range; zero where there is no value.
pub fn polynomial(order: usize, value: f64, range: [f64; 2]) -> f64 {
    place(value, range).and_then(|x| physics::chebyshev(x).nth(order - 1)).unwrap_or(0.0)
}

/// So many half waves over the span of the campaign's clock at a row, the Chebyshev polynomials of the first.
pub fn half_waves(order: usize, run: &Run<'_>, row: usize, (from, length): (f64, f64)) -> Option<f64> {
    let time = run.time_s?[row] + run.setting.context.clock_s;
    Some((PI * order as f64 * (time - from) / length).cos())
}

/// Mean time from one row to the next.
pub fn mean_step_s(time: &[f64]) -> f64 {
    (time[time.len() - 1] - time[0]) / (time.len().max(2) - 1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_those_of_chebyshev() {
        for x in [-1.0_f64, -0.3, 0.0, 0.8, 1.0] {
            let value = 10.0 + 5.0 * x;
            assert!((polynomial(2, value, [5.0, 15.0]) - (2.0 * x * x - 1.0)).abs() < 1e-12);
            assert!((polynomial(3, value, [5.0, 15.0]) - (4.0 * x.powi(3) - 3.0 * x)).abs() < 1e-12);
        }
        assert_eq!(polynomial(2, f64::NAN, [5.0, 15.0]), 0.0);
        assert_eq!(range([2.0, f64::NAN, -1.0].iter()), Some([-1.0, 2.0]));
        assert_eq!(range([2.0, 2.0].iter()), None);
    }
}
