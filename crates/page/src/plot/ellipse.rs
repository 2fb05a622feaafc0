use super::drawn::{Mark, Point, Series};

/// Points of an ellipse.
const POINTS: usize = 72;

/// The region of two quantities with this covariance at a level: (p − c)ᵀ C⁻¹ (p − c) = −2 ln(1 − level), the
/// χ² of two degrees of freedom.
pub fn ellipse(
    name: impl Into<String>,
    style: usize,
    centre: [f64; 2],
    covariance: [[f64; 2]; 2],
    level: f64,
) -> Series {
    let radius = (-2.0 * (1.0 - level).ln()).sqrt();
    // Cholesky factor of the covariance; rounding may leave a variance a little below zero.
    let a = covariance[0][0].max(0.0).sqrt();
    let b = if a > 0.0 { covariance[1][0] / a } else { 0.0 };
    let c = (covariance[1][1] - b * b).max(0.0).sqrt();
    let point = |n: usize| {
        let (sin, cos) = (n as f64 / POINTS as f64 * std::f64::consts::TAU).sin_cos();
        Point { x: centre[0] + radius * a * cos, y: centre[1] + radius * (b * cos + c * sin), bar: None }
    };
    Series { name: name.into(), mark: Mark::Line, style, points: (0..=POINTS).map(point).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_has_the_same_mahalanobis_distance() {
        let [[p, q], [_, r]] = [[4.0, 1.5], [1.5, 1.0]];
        let series = ellipse("e", 0, [10.0, -3.0], [[p, q], [q, r]], 0.95);
        for point in &series.points {
            let (x, y) = (point.x - 10.0, point.y + 3.0);
            let squared = (r * x * x - 2.0 * q * x * y + p * y * y) / (p * r - q * q);
            // 5.991 is the 95 % point of χ² with two degrees of freedom.
            assert!((squared - 5.991_464_547).abs() < 1e-6, "{squared}");
        }
    }
}
