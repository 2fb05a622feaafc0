//! The Whittle fit against SciPy, its choice of the white noise, its bounds, and whether it knows noise that
//! is not its own.

use estimate::Error;
use estimate::line_search::largest;
use estimate::periodogram::{Bin, Periodogram, periodogram};
use estimate::whittle::{White, fit, fit_with};
use noise::Stream;
use serde_json::Value;
use testkit::reference::{list, number, numbers, reference};

use crate::made::made;

fn seen(samples: &[f64], step_s: f64) -> Periodogram {
    periodogram(samples, step_s).expect("a periodogram")
}

#[test]
fn maxima_of_scipy() {
    let reference = reference("whittle_scipy");
    let of = |series: &Value| seen(&numbers(&series["samples"]), number(&series["step_s"]));
    let series: Vec<Periodogram> = list(&reference["series"]).iter().map(of).collect();
    for (form, white) in
        [("per_reading", White::PerReading), ("density", White::Density), ("each", White::Each)]
    {
        let expected = &reference["fits"][form];
        let found = fit_with(&series, white).expect("a fit");
        let covariance: Vec<Vec<f64>> = list(&expected["covariance"]).iter().map(numbers).collect();
        let estimates =
            [&[found.amplitude.value.ln(), found.exponent.value][..], &found.white_variances].concat();
        let truths = [number(&expected["ln_amplitude"]), number(&expected["exponent"])];
        let truths = [&truths[..], &numbers(&expected["white_variances"])].concat();
        assert_eq!(estimates.len(), truths.len());
        let (mut off, mut off_covariance) = (0.0_f64, 0.0_f64);
        for i in 0..truths.len() {
            off = off.max((estimates[i] - truths[i]).abs() / covariance[i][i].sqrt());
            for (j, own) in covariance[i].iter().enumerate() {
                let scale = (covariance[i][i] * covariance[j][j]).sqrt();
                off_covariance = off_covariance.max((found.covariance[(i, j)] - own).abs() / scale);
            }
        }
        // The bins: 0.003, 0.012 and 0.005 standard errors were seen.
        assert!(off < 0.02, "{form}: {off} standard errors");
        assert!(off_covariance < 0.02, "{form}: {off_covariance}");
    }
    assert_eq!(fit(&series).expect("a fit").white, White::PerReading);
}

#[test]
fn exact_ordinates_give_the_truth() {
    // Ordinates that are the density itself have their maximum at it.
    let density = |f: f64, step_s: f64| 3e-4 * f.powf(-1.3) + 2.0 * 0.05_f64.powi(2) * step_s;
    let made = |n: usize, step_s: f64| {
        let bin = |k: usize| {
            let frequency_hz = k as f64 / (n as f64 * step_s);
            Bin { frequency_hz, density: density(frequency_hz, step_s), count: 1.0 }
        };
        let bins = (1..n / 2).map(bin).collect();
        Periodogram { length_s: n as f64 * step_s, step_s, samples: n, mirrored: false, bins, lines: vec![] }
    };
    let found = fit(&[made(900, 10.0), made(2000, 0.02)]).expect("a fit");
    assert_eq!(found.white, White::PerReading);
    assert!((found.amplitude.value / 3e-4 - 1.0).abs() < 1e-5, "{:?}", found.amplitude);
    assert!((found.exponent.value - 1.3).abs() < 1e-6 && (found.white_rms[1].value - 0.05).abs() < 1e-7);
    let at = found.density(1, 0.5, 0.2);
    assert!((at.value / density(0.2, 0.5) - 1.0).abs() < 1e-6);
    assert!((found.flicker_density(0.2).value / (3e-4 * 0.2_f64.powf(-1.3)) - 1.0).abs() < 1e-5);
    // The variance in a narrow band is that of the density, and its uncertainty too.
    let (narrow, flicker) = (found.flicker_variance(0.2, 0.2001), found.flicker_density(0.2));
    assert!((narrow.value / 1e-4 / flicker.value - 1.0).abs() < 1e-3);
    assert!((narrow.std / 1e-4 / flicker.std - 1.0).abs() < 1e-3);
    let sum = found.flicker_variance(0.01, 1.0).value + found.flicker_variance(1.0, 7.0).value;
    assert!((found.flicker_variance(0.01, 7.0).value / sum - 1.0).abs() < 1e-12, "bands add up");
    assert!(
        found.flicker_variance(0.0, 1.0).value.is_nan() && found.flicker_variance(2.0, 1.0).value.is_nan()
    );
}

#[test]
fn the_form_of_the_white_noise() {
    let steps = [(1000, 10.0), (2000, 1.0), (3000, 0.1)];
    let with = |rms: [f64; 3]| {
        let mut stream = Stream::new(3, "forms");
        let series: Vec<Periodogram> = steps
            .iter()
            .zip(rms)
            .map(|(&(n, step_s), rms)| seen(&made(&mut stream, (n, step_s), (1e-4, 1.0), rms), step_s))
            .collect();
        fit(&series).expect("a fit")
    };
    assert_eq!(with([0.05; 3]).white, White::PerReading);
    // A density of 2e-3: σ = √(N/(2 Δt)).
    let density = with([0.01, 0.01 * 10.0_f64.sqrt(), 0.1]);
    assert_eq!(density.white, White::Density);
    assert!((density.white_variances[0] / 2e-3 - 1.0).abs() < 0.1);
    assert!((density.white_rms[2].value / 0.1 - 1.0).abs() < 0.05);
    let each = with([0.05, 0.1, 0.05]);
    assert_eq!(each.white, White::Each);
    assert!((each.white_rms[1].value - 0.1).abs() < 3.0 * each.white_rms[1].std);
    assert!((each.white_rms[2].value - 0.05).abs() < 3.0 * each.white_rms[2].std);
    // One series leaves nothing to choose.
    let mut stream = Stream::new(4, "forms");
    let one = fit(&[seen(&made(&mut stream, (2000, 1.0), (1e-4, 1.0), 0.02), 1.0)]).expect("a fit");
    assert_eq!(one.white, White::PerReading);
}

/// Least Σ count (ln P + I/P) over the white variance for P = A/f (1 − 1/(π² f T)) + 2 w Δt.
fn least_cost(series: &Periodogram, amplitude: f64) -> f64 {
    let cost = |ln_white: f64| {
        let term = |bin: &Bin| {
            let seen = 1.0 - 1.0 / (std::f64::consts::PI.powi(2) * bin.frequency_hz * series.length_s);
            let density = amplitude / bin.frequency_hz * seen + 2.0 * ln_white.exp() * series.step_s;
            bin.count * (density.ln() + bin.density / density)
        };
        series.bins.iter().map(term).sum::<f64>()
    };
    cost(largest((-12.0, -4.0), 80, |ln_white| -cost(ln_white)))
}

#[test]
fn no_flicker_has_a_bound() {
    let mut stream = Stream::new(5, "white");
    let series = seen(&made(&mut stream, (3000, 1.0), (0.0, 1.0), 0.02), 1.0);
    let found = fit(std::slice::from_ref(&series)).expect("a fit");
    let bound = found.amplitude.bound().expect("no flicker");
    assert_eq!((found.amplitude.value, found.exponent.value, found.exponent.std), (0.0, 1.0, 0.0));
    assert!((found.amplitude.log_interval(0.95).1 / bound - 1.0).abs() < 1e-5);
    // The likelihood ratio at the bound, from the ordinates themselves.
    let best = (0..4000).map(|i| least_cost(&series, 1e-8 * f64::from(i))).fold(f64::INFINITY, f64::min);
    let fall = 2.0 * (least_cost(&series, bound) - best);
    assert!((fall - 1.645_f64.powi(2)).abs() < 0.01, "{fall}");
    // Weak flicker is below the bound, or it is found with an interval that holds it: in 95 of a hundred
    // series, and in 90 near the limit of significance, where it is sometimes the one and sometimes the
    // other.
    for weak in [1e-7, 3e-7, 1e-6] {
        let (mut below, mut held) = (0, 0);
        for number in 0..200 {
            let mut stream = Stream::new(number, "weak");
            let found = fit(&[seen(&made(&mut stream, (3000, 1.0), (weak, 1.0), 0.02), 1.0)]).expect("a fit");
            match found.amplitude.bound() {
                Some(bound) => below += usize::from(bound >= weak),
                None => {
                    let (low, high) = found.amplitude.log_interval(0.95);
                    held += usize::from((low..=high).contains(&weak));
                }
            }
        }
        assert!(below + held >= 174, "{weak:e}: {below} and {held}");
    }
}

#[test]
fn no_white_noise_has_a_bound() {
    let (mut none, mut held) = (0, 0);
    for number in 0..100 {
        let mut stream = Stream::new(number, "pink");
        let series = [
            seen(&made(&mut stream, (1000, 10.0), (1e-4, 1.0), 0.0), 10.0),
            seen(&made(&mut stream, (2000, 0.1), (1e-4, 1.0), 0.0), 0.1),
        ];
        let found = fit(&series).expect("a fit");
        let (low, high) = found.amplitude.log_interval(0.95);
        held += usize::from((low..high).contains(&1e-4));
        if let Some(bound) = found.white_rms[0].bound() {
            none += 1;
            // Far below the flicker of a reading at the highest frequency, 2 σ² Δt = A/f.
            assert!(bound > 0.0 && bound < 0.02, "{bound}");
        }
    }
    assert!(none >= 97 && held >= 90, "{none}, {held}");
}

#[test]
fn other_noise_is_not_described() {
    // A resonance: x_m = 1.6 x_(m−1) − 0.9 x_(m−2) + noise.
    let mut stream = Stream::new(6, "resonance");
    let mut samples = vec![0.0, 0.0];
    for m in 2..4000 {
        samples.push(1.6 * samples[m - 1] - 0.9 * samples[m - 2] + stream.normal());
    }
    let found = fit(&[seen(&samples, 1.0)]).expect("a fit");
    assert!(found.goodness.expect("groups") < 1e-6, "{:?}", found.goodness);
}

#[test]
fn what_has_no_spectrum_is_refused() {
    let mut stream = Stream::new(7, "short");
    let short = made(&mut stream, (8, 1.0), (0.0, 1.0), 1.0);
    assert!(matches!(periodogram(&short[..7], 1.0), Err(Error::TooFew { found: 7, unknowns: 8 })));
    assert!(matches!(fit(&[seen(&short, 1.0)]), Err(Error::TooFew { found: 3, unknowns: 4 })));
    assert!(matches!(fit(&[]), Err(Error::TooFew { .. })));
    for step_s in [0.0, f64::NAN] {
        assert!(matches!(periodogram(&short, step_s), Err(Error::Series(_))));
    }
    assert!(matches!(periodogram(&[f64::NAN; 8], 1.0), Err(Error::Series(_))));
    assert!(matches!(fit(&[seen(&[50_000.1; 100], 1.0)]), Err(Error::Series(_))));
}
