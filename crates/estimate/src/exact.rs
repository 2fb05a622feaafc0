//! Sums that carry their rounding error along, so that their order does not matter.

use serde::{Deserialize, Serialize};

/// A sum with what its rounding left: some 106 bits. JSON writes both as a list.
///
/// Source: T. J. Dekker, A floating-point technique for extending the available precision, Numer. Math. 18
/// (1971) 224–242.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sum(f64, f64);

/// a + b and its rounding error, exactly (Knuth).
#[inline]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

impl Sum {
    /// One number.
    pub fn of(value: f64) -> Self {
        Sum(value, 0.0)
    }

    /// Adds a number.
    #[inline]
    pub fn add(&mut self, value: f64) {
        let (sum, error) = two_sum(self.0, value);
        *self = Sum(sum, self.1 + error);
    }

    /// Adds another sum.
    #[inline]
    pub fn add_sum(&mut self, other: Sum) {
        self.add(other.0);
        self.1 += other.1;
    }

    /// Adds a multiple of another sum.
    pub fn add_times(&mut self, factor: f64, other: Sum) {
        let product = factor * other.0;
        self.add(product);
        self.1 += factor.mul_add(other.0, -product) + factor * other.1;
    }

    /// The sum, rounded.
    #[inline]
    pub fn value(self) -> f64 {
        self.0 + self.1
    }

    /// The sum over a count.
    pub fn over(self, count: f64) -> Sum {
        let first = self.0 / count;
        let rest = (-first).mul_add(count, self.0) + self.1;
        Sum(first, rest / count)
    }

    /// This less another, rounded once.
    #[inline]
    pub fn less(self, other: Sum) -> f64 {
        let (difference, error) = two_sum(self.0, -other.0);
        difference + (error + (self.1 - other.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_does_not_matter() {
        let values: Vec<f64> =
            (0..10_000).map(|i| 5e4 + (f64::from(i) * 0.7).sin() * 1e-3 * f64::from(i)).collect();
        let (mut up, mut down, mut halves) = (Sum::default(), Sum::default(), [Sum::default(); 2]);
        values.iter().for_each(|v| up.add(*v));
        values.iter().rev().for_each(|v| down.add(*v));
        values.iter().enumerate().for_each(|(i, v)| halves[i % 2].add(*v));
        let mut both = halves[1];
        both.add_sum(halves[0]);
        assert_eq!(up.value(), down.value());
        assert_eq!(up.value(), both.value());
        assert!(up.less(both).abs() < 1e-20 * up.value());
        // 1e16 + 1 − 1e16 is lost in a plain sum.
        let mut sum = Sum::of(1e16);
        sum.add(1.0);
        assert_eq!(sum.less(Sum::of(1e16)), 1.0);
        let mut product = Sum::of(-0.1);
        product.add_times(0.1, Sum::of(1.0).over(3.0));
        let mut third = Sum::default();
        (0..3).for_each(|_| third.add_sum(Sum::of(1.0).over(3.0)));
        assert!((third.less(Sum::of(1.0))).abs() < 1e-31);
        assert!((product.value() + 0.1 - 0.1 / 3.0).abs() < 1e-17);
    }
}
