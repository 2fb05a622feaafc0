//! A transform and its inverse.

use fourier::{Complex, forward, inverse};

#[test]
fn there_and_back_is_n_times_the_series() {
    for points in [1, 2, 7, 31, 64, 90] {
        let series: Vec<f64> = (0..points).map(|n| (n as f64 * 0.7).sin() + 0.1).collect();
        let (there, back) = (forward(points), inverse(points));
        let mut spectrum = there.make_output_vec();
        there.process(&mut series.clone(), &mut spectrum).expect("lengths that fit");
        assert!((spectrum[0] - Complex::new(series.iter().sum(), 0.0)).norm() < 1e-12);
        let mut returned = back.make_output_vec();
        back.process(&mut spectrum, &mut returned).expect("lengths that fit");
        for (found, given) in returned.iter().zip(&series) {
            assert!((found - points as f64 * given).abs() < 1e-12 * points as f64, "{points}");
        }
    }
}
