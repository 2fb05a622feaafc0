//! The integration tests of `fourier`: a transform and its inverse.

use fourier::{Complex, forward, inverse};

#[test]
fn there_and_back_is_n_times_the_series() {
    for points in [1, 2, 7, 31, 64, 90] {
        let series: Vec<f64> = (0..points).map(|n| (n as f64 * 0.7).sin() + 0.1).collect();
        let spectrum = forward(series.clone());
        assert!((spectrum[0] - Complex::new(series.iter().sum(), 0.0)).norm() < 1e-12);
        for (found, given) in inverse(spectrum, points).iter().zip(&series) {
            assert!((found - points as f64 * given).abs() < 1e-12 * points as f64, "{points}");
        }
    }
}
