//! Haar variances against SciPy's integrals (fixtures/reference/haar_scipy.py) and against made noise.

use estimate::haar::{power_law_variances, sum_covariance};
use noise::Stream;
use testkit::reference::{list, number, reference};

#[test]
fn scipy_has_the_same() {
    let mut worst: f64 = 0.0;
    for case in list(&reference("haar_scipy")["cases"]) {
        let level = number(&case["level"]) as usize;
        let found = power_law_variances(number(&case["exponent"]), level + 1)[level];
        worst = worst.max((found / number(&case["variance"]) - 1.0).abs());
    }
    assert!(worst < 1e-7, "{worst}");
}

/// Noise made for the frequencies of one series and none lower, so long that the levels looked at do not feel
/// it: variances by level, and the covariance of a difference with the next one and with its own halves'
/// differences.
#[test]
fn made_noise_has_these_variances() {
    const ROWS: usize = 1 << 16;
    const SERIES: u64 = 60;
    const LEVELS: usize = 9;
    for exponent in [0.6, 1.0, 1.5] {
        let expected = power_law_variances(exponent, LEVELS);
        let g = sum_covariance(exponent);
        // Neighbours of long blocks: Σ a_i b_j over the ends 0, 1, 2 and 2, 3, 4.
        let next = -(0..3)
            .flat_map(|i| (0..3).map(move |j| (i, j)))
            .map(|(i, j)| [1.0, -2.0, 1.0][i] * [1.0, -2.0, 1.0][j] * g((2 + j) as f64 - i as f64))
            .sum::<f64>();
        let ratio = next / (8.0 * g(1.0) - 2.0 * g(2.0));
        let (mut sums, mut squares, mut neighbours) = ([0.0; LEVELS], [0.0; LEVELS], 0.0);
        for seed in 0..SERIES {
            let mut stream = Stream::new(seed, "haar");
            let mut means = noise::power_law(&mut stream, ROWS, 1.0, 1.0, exponent);
            for (level, (sum, square)) in sums.iter_mut().zip(&mut squares).enumerate() {
                let differences: Vec<f64> = means.chunks_exact(2).map(|pair| pair[1] - pair[0]).collect();
                let count = differences.len() as f64;
                let mean = differences.iter().map(|d| d * d).sum::<f64>() / count;
                *sum += mean / SERIES as f64;
                *square += mean * mean / SERIES as f64;
                if level == 6 {
                    let product: f64 = differences.windows(2).map(|pair| pair[0] * pair[1]).sum();
                    neighbours += product / (count - 1.0) / SERIES as f64;
                }
                means = means.chunks_exact(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
            }
        }
        for (level, ((sum, square), expected)) in sums.iter().zip(squares).zip(expected).enumerate() {
            let error = ((square - sum * sum) / (SERIES - 1) as f64).sqrt();
            assert!((sum - expected).abs() < 4.0 * error, "{exponent} {level}");
        }
        let measured = neighbours / sums[6];
        assert!((measured - ratio).abs() < 0.02, "{exponent}: {measured} for {ratio}");
    }
}
