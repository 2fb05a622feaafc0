//! How far two errors together reach.

use std::f64::consts::TAU;

/// Directions over which the density is summed.
const DIRECTIONS: usize = 720;

/// The length that two normal errors of this covariance stay within with a probability p; where both are σ, σ
/// √(−2 ln(1 − p)). P(r) = ∫ (1 − exp(−r² q/2))/q dφ/(2πab), q = cos²φ/a² + sin²φ/b².
pub fn radius(covariance: [[f64; 2]; 2], probability: f64) -> f64 {
    let [a, b] = axes(covariance);
    if a == 0.0 {
        return 0.0;
    }
    // In units of the longer axis; a shorter one below a hundredth of it adds nothing that counts.
    let b = (b / a).max(0.01);
    let within = |r: f64| -> f64 {
        let each = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / DIRECTIONS as f64).sin_cos();
            let q = cos * cos + sin * sin / (b * b);
            -(-0.5 * r * r * q).exp_m1() / q
        };
        (0..DIRECTIONS).map(each).sum::<f64>() / (DIRECTIONS as f64 * b)
    };
    let (mut low, mut high) = (0.0, 10.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if within(middle) < probability { low = middle } else { high = middle }
    }
    a * high
}

/// Shapes of ellipses for which the reach is worked out; between them it is read off by straight lines.
const SHAPES: usize = 100;

/// How far two errors reach with one probability, for many covariances.
#[derive(Clone, Debug)]
pub struct Reach {
    /// For a shorter axis of 0, 1/100, … 1 times the longer one.
    by_shape: Vec<f64>,
}

impl Reach {
    pub fn new(probability: f64) -> Self {
        let of = |shape: usize| {
            let b = shape as f64 / SHAPES as f64;
            radius([[1.0, 0.0], [0.0, b * b]], probability)
        };
        Self { by_shape: (0..=SHAPES).map(of).collect() }
    }

    /// As [`radius`], within a ten thousandth.
    pub fn of(&self, covariance: [[f64; 2]; 2]) -> f64 {
        let [long, short] = axes(covariance);
        if long == 0.0 {
            return 0.0;
        }
        let at = (short / long * SHAPES as f64).min(SHAPES as f64 - 1e-9);
        let (below, share) = (at as usize, at.fract());
        long * (self.by_shape[below] + share * (self.by_shape[below + 1] - self.by_shape[below]))
    }
}

/// Standard deviations along the longer and the shorter axis of the ellipse.
pub fn axes([[xx, xy], [_, yy]]: [[f64; 2]; 2]) -> [f64; 2] {
    let (mean, half) = (0.5 * (xx + yy), (0.25 * (xx - yy).powi(2) + xy * xy).sqrt());
    [mean + half, mean - half].map(|variance| variance.max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reaches_are_read_off_a_table() {
        let reach = Reach::new(0.95);
        for covariance in [[[1.0, 0.0], [0.0, 1.0]], [[2.5, 1.5], [1.5, 2.5]], [[1.0, 0.0], [0.0, 0.002_5]]] {
            let exact = radius(covariance, 0.95);
            assert!((reach.of(covariance) / exact - 1.0).abs() < 1e-4, "{covariance:?}");
        }
        assert_eq!(reach.of([[0.0; 2]; 2]), 0.0);
    }

    #[test]
    fn circles_and_lines() {
        // Both ways alike: Rayleigh, √(−2 ln 0.05) = 2.4477. One way alone: 1.95996.
        assert!((radius([[4.0, 0.0], [0.0, 4.0]], 0.95) - 2.0 * 2.447_747).abs() < 1e-5);
        assert!((radius([[1.0, 0.0], [0.0, 0.0]], 0.95) - 1.959_964).abs() < 1e-3);
        // Along a diagonal: the same ellipse turned.
        let turned = radius([[2.5, 1.5], [1.5, 2.5]], 0.95);
        assert!((turned - radius([[4.0, 0.0], [0.0, 1.0]], 0.95)).abs() < 1e-9);
        assert_eq!(radius([[0.0; 2]; 2], 0.95), 0.0);
    }
}
