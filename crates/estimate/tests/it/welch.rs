//! Welch's spectrum against SciPy, against the variance it has to add up to, and its interval against the
//! truth.

use estimate::Error;
use estimate::spectrum::{Spectrum, welch};
use estimate::stats::variance_interval;
use noise::Stream;
use testkit::reference::{list, number, numbers, reference};

use crate::made::white;

fn made(seed: u64, count: usize, std: f64) -> Vec<f64> {
    white(&mut Stream::new(seed, "welch"), count, std)
}

#[test]
fn densities_of_scipy() {
    let reference = reference("welch_scipy");
    let mut compared = 0;
    for series in list(&reference["series"]) {
        let samples = numbers(&series["samples"]);
        for expected in list(&series["spectra"]) {
            let asked = number(&expected["asked"]) as usize;
            let spectrum = welch(&samples, number(&series["step_s"]), asked).expect("a spectrum");
            let name = format!("{} samples, segments of {asked}", samples.len());
            let n = number(&expected["segment_samples"]) as usize;
            assert_eq!(spectrum.segment_samples, n, "{name}");
            assert_eq!(spectrum.segments, number(&expected["segments"]) as usize, "{name}");
            assert_eq!(spectrum.overlap, (n / 2) as f64 / n as f64, "{name}");
            let freedom = number(&expected["freedom"]);
            assert!((spectrum.freedom / freedom - 1.0).abs() < 1e-12, "{name}: {}", spectrum.freedom);

            let (frequency, density) = (numbers(&expected["frequency_hz"]), numbers(&expected["density"]));
            assert_eq!(
                (spectrum.frequency_hz.len(), spectrum.density.len()),
                (frequency.len(), density.len())
            );
            for (found, expected) in spectrum.frequency_hz.iter().zip(&frequency) {
                assert!((found - expected).abs() <= 1e-14 * expected, "{name}: {found} Hz, {expected} Hz");
            }
            let largest = density.iter().copied().fold(0.0, f64::max);
            for (k, (found, expected)) in spectrum.density.iter().zip(&density).enumerate() {
                let off = (found - expected).abs();
                assert!(off <= 1e-10 * expected + 1e-14 * largest, "{name}, bin {k}: {found}, {expected}");
                compared += 1;
            }
        }
    }
    assert!(compared > 1500);
}

#[test]
fn factors_of_scipy() {
    // The quantiles ν/factor are known to about 1e-9 each, whatever their size.
    for expected in list(&reference("welch_scipy")["intervals"]) {
        let freedom = number(&expected["freedom"]);
        let (low, high) = variance_interval(freedom, number(&expected["probability"]));
        for (found, key) in [(low, "low"), (high, "high")] {
            let quantile = freedom / number(&expected[key]);
            let off = (freedom / found - quantile).abs();
            assert!(off < 2e-9 * (1.0 + quantile), "{expected}: {key} {found}");
            assert!((found / number(&expected[key]) - 1.0).abs() < 2e-6, "{expected}: {key} {found}");
        }
    }
}

#[test]
fn ends_of_the_probability() {
    assert_eq!(variance_interval(20.0, 1.0), (0.0, f64::INFINITY));
    let (low, high) = variance_interval(20.0, 0.0);
    assert!((low - high).abs() < 1e-9 && low > 1.0, "the median of χ² is below its mean: {low}, {high}");
    // So many degrees of freedom that χ² is as good as normal: 1 ∓ 1.959964 √(2/ν).
    let ((low, high), half) = (variance_interval(5.7e6, 0.95), 1.959_964 / 2.85e6_f64.sqrt());
    assert!((low - (1.0 - half)).abs() < 2e-6 && (high - (1.0 + half)).abs() < 2e-6, "{low}, {high}");
    for (freedom, probability) in [(20.0, -0.1), (20.0, 1.1), (20.0, f64::NAN), (f64::NAN, 0.95)] {
        let (low, high) = variance_interval(freedom, probability);
        assert!(low.is_nan() && high.is_nan());
    }
}

#[test]
fn too_few_samples_are_refused() {
    let samples = made(1, 20, 1.0);
    for (samples, segment) in [(&samples[..7], 7), (&samples[..7], 100), (&samples[..], 7), (&samples[..], 0)]
    {
        let found = samples.len().min(segment);
        match welch(samples, 1.0, segment) {
            Err(Error::TooFew { found: said, unknowns: 8 }) => assert_eq!(said, found),
            other => panic!("{other:?}"),
        }
    }
    assert!(welch(&samples[..8], 1.0, 8).is_ok());
}

#[test]
fn the_interval_covers_the_truth() {
    // Bins four apart share next to nothing: 400 series of nine bins, the share known to 0.004.
    let (step_s, std, mut stream) = (0.5, 0.3, Stream::new(4, "welch"));
    let truth = 2.0 * std * std * step_s;
    for (count, n) in [(1024, 128), (1000, 101), (300, 200), (96, 96)] {
        let (mut inside, mut all) = (0, 0);
        for _ in 0..400 {
            let spectrum = welch(&white(&mut stream, count, std), step_s, n).expect("a spectrum");
            let (low, high) = variance_interval(spectrum.freedom, 0.95);
            for p in spectrum.density[4..n / 2 - 3].iter().step_by(4).take(9) {
                inside += usize::from((p * low..p * high).contains(&truth));
                all += 1;
            }
        }
        let share = inside as f64 / all as f64;
        assert!((0.93..0.97).contains(&share), "{count} samples, segments of {n}: {share}");
    }
}

#[test]
fn power_of_a_band() {
    let close = |a: f64, b: f64| (a - b).abs() < 1e-13;
    let of = |frequency_hz: Vec<f64>, density: Vec<f64>| Spectrum {
        frequency_hz,
        density,
        segments: 1,
        segment_samples: 8,
        overlap: 0.5,
        freedom: 10.0,
    };
    let frequency: Vec<f64> = (0..=50).map(|k| f64::from(k) * 0.01).collect();
    // At zero a density that must not be seen.
    let mut density = vec![3.0; 51];
    density[0] = 1e6;
    let level = of(frequency.clone(), density);
    assert!(close(level.power(0.013, 0.377), 3.0 * 0.364));
    assert!(close(level.power(0.2, 0.3), 0.3), "the ends on frequencies");
    assert!(close(level.power(0.212, 0.217), 0.015), "between two frequencies");
    assert!(close(level.power(0.0, 0.1), 0.27), "nothing below the first frequency after zero");
    assert!(close(level.power(0.4, 9.0), 0.3), "nothing beyond the last");
    assert!(close(level.power(0.0, f64::INFINITY), 1.47));
    for (low, high) in [(0.3, 0.3), (0.3, 0.2), (0.0, 0.01), (0.5, 0.6)] {
        assert_eq!(level.power(low, high), 0.0, "{low} … {high}");
    }
    assert!(level.power(f64::NAN, 0.3).is_nan() && level.power(0.3, f64::NAN).is_nan());
    assert_eq!(of(vec![], vec![]).power(0.0, 1.0), 0.0);

    // A straight line P = 2 f has the integral f².
    let line = of(frequency.clone(), frequency.iter().map(|f| 2.0 * f).collect());
    assert!(close(line.power(0.1234, 0.4321), 0.4321_f64.powi(2) - 0.1234_f64.powi(2)));
    assert!(close(line.power(0.1, 0.2345) + line.power(0.2345, 0.4), line.power(0.1, 0.4)), "bands add up");
}
