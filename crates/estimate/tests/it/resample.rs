//! Resampling against SciPy (fixtures/reference/resample_scipy.py), against sines, and where readings are
//! missing.

use estimate::even::pchip;
use estimate::resample::{PASSBAND, resample};
use std::f64::consts::PI;
use testkit::reference::{list, number, numbers, reference};

#[test]
fn as_scipy_has_it() {
    let mut worst = 0.0_f64;
    for case in list(&reference("resample_scipy")["ratios"]) {
        let (samples, expected) = (numbers(&case["samples"]), numbers(&case["resampled"]));
        let [up, down] = ["up", "down"].map(|key| number(&case[key]));
        let stretch = (down / up).max(1.0);
        let places: Vec<f64> = (0..expected.len()).map(|k| k as f64 * down / up).collect();
        let found = resample(std::slice::from_ref(&samples), &places, stretch);
        let reach = 26.0 * stretch;
        let inside = |place: f64| place >= reach && place + reach <= samples.len() as f64 - 1.0;
        let pairs = found.columns[0].iter().zip(&expected).zip(&places).filter(|(_, place)| inside(**place));
        assert!(pairs.clone().count() > 20);
        worst = pairs.map(|((a, b), _)| (a - b).abs()).fold(worst, f64::max);
    }
    assert!(worst < 2e-6, "{worst:.1e} of samples of about 5");
}

#[test]
fn ripple_and_attenuation() {
    let design = &reference("resample_scipy")["design"];
    let [ripple, stop] = ["passband_ripple", "stopband_gain"].map(|key| number(&design[key]));
    assert!(ripple < 2e-4 && stop < 1e-4, "{ripple:.1e}, {stop:.1e}");
    // A sine through the resampling itself: four input samples to one output, 0.3 of an output step beside
    // its grid.
    let gain = |share: f64| {
        let omega = PI * share / 4.0;
        let wave = |at: f64| (omega * at + 0.4).sin();
        let samples: Vec<f64> = (0..1200).map(|k| wave(f64::from(k))).collect();
        let places: Vec<f64> = (30..260).map(|k| 4.0 * f64::from(k) + 1.2).collect();
        let found = resample(&[samples], &places, 4.0);
        found.columns[0]
            .iter()
            .zip(&places)
            .map(|(y, place)| if share < 1.0 { (y - wave(*place)).abs() } else { y.abs() })
            .fold(0.0, f64::max)
    };
    let passed = (0..=90).map(|k| gain(PASSBAND * f64::from(k) / 90.0)).fold(0.0, f64::max);
    let stopped = (0..=290).map(|k| gain(2.0 - PASSBAND + 0.01 * f64::from(k))).fold(0.0, f64::max);
    assert!(passed < 2e-4 && stopped < 1e-4, "{passed:.1e}, {stopped:.1e}");
}

#[test]
fn own_times_leave_a_series_as_it_is() {
    let samples: Vec<f64> = (0..200).map(|k| 50_000.0 + f64::from(k * k % 37)).collect();
    let places: Vec<f64> = (0..200).map(f64::from).collect();
    let found = resample(std::slice::from_ref(&samples), &places, 1.0);
    assert!(found.columns[0].iter().zip(&samples).all(|(a, b)| (a - b).abs() < 1e-9));
    assert!((found.white_share - 1.0).abs() < 1e-12);
    // White noise averaged to a sixtieth of the rate: about 1/√60.
    let found = resample(&[vec![0.0; 6000]], &[3000.0], 60.0);
    assert!((found.white_share * 60.0_f64.sqrt() - 1.0).abs() < 0.05, "{}", found.white_share);
}

#[test]
fn missing_rows_cost_what_they_weigh() {
    let line = |k: f64| 20_000.0 + 3.0 * k;
    let mut samples: Vec<f64> = (0..400).map(|k| line(f64::from(k))).collect();
    samples[200] = f64::NAN;
    let places: Vec<f64> = (0..399).map(|k| f64::from(k) + 0.5).collect();
    let other = vec![1.0; 400];
    let found = resample(&[samples.clone(), other], &places, 1.0);
    let lost: Vec<usize> = (0..399).filter(|k| found.columns[0][*k].is_nan()).collect();
    assert!(lost.contains(&199) && lost.contains(&200));
    assert!(lost.iter().all(|k| *k < 4 || *k >= 395 || (199..=200).contains(k)), "{lost:?}");
    for (k, place) in places.iter().enumerate().filter(|(k, _)| !lost.contains(k)) {
        assert!((found.columns[0][k] - line(*place)).abs() < 1e-6, "a straight line stays one: row {k}");
        assert!((found.columns[1][k] - 1.0).abs() < 1e-12);
    }
    assert!(lost.iter().all(|k| found.columns[1][*k].is_nan()), "a row is missing in all columns");
    // One second of a minute's mean.
    let found = resample(&[samples], &[190.0], 6.0);
    assert!(found.columns[0][0].is_finite());
    assert!(resample(&[vec![f64::NAN; 9]], &[3.0], 1.0).columns[0][0].is_nan());
}

#[test]
fn uneven_series_as_scipy_has_them() {
    let case = &reference("resample_scipy")["uneven"];
    let [time, values, at, expected] = ["time", "values", "at", "read"].map(|key| numbers(&case[key]));
    let found = pchip(&time, &values, &at);
    let worst = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-12, "{worst:.1e}");
    assert!(pchip(&time, &values, &[time[0] - 1.0, time[59] + 1.0]).iter().all(|value| value.is_nan()));
}
