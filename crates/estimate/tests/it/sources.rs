//! Noise of three instruments from two differences as SciPy finds it, and as it was made.

use estimate::cross_spectrum::CrossSpectra;
use estimate::sources::{KnownNoise, Mixture, Sources, fit};
use estimate::whittle::Estimate;
use noise::Stream;
use serde_json::Value;
use testkit::reference::{numbers, reference};

use crate::made::white;

const COLUMNS: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];

fn columns(from: usize) -> Vec<Vec<f64>> {
    COLUMNS[from..].iter().map(|column| column.to_vec()).collect()
}

/// The largest difference from SciPy's ln A, α and σ² in its standard errors, and of these themselves,
/// relative.
fn compare(found: &Sources, from: usize, step_s: f64, expected: &Value) -> [f64; 2] {
    let (theta, std) = (numbers(&expected["theta"]), numbers(&expected["std"]));
    let mut worst = [0.0_f64; 2];
    for (place, source) in found.sources.iter().enumerate() {
        let first = 3 * (from + place);
        assert!(source.exponent.std > 0.0, "flicker of source {place} is significant");
        let relative = |of: Estimate| of.std / of.value;
        // White noise that is not significant is reported as none; the fit has it all the same.
        let white = (source.density(1.0) - source.amplitude.value) / (2.0 * step_s);
        let all = [
            (source.amplitude.value.ln(), relative(source.amplitude)),
            (source.exponent.value, source.exponent.std),
            (white.ln(), 2.0 * relative(source.white_rms)),
        ];
        for (i, (value, uncertainty)) in all.into_iter().enumerate() {
            worst[0] = worst[0].max((value - theta[first + i]).abs() / std[first + i]);
            if uncertainty.is_finite() {
                worst[1] = worst[1].max((uncertainty / std[first + i] - 1.0).abs());
            }
        }
    }
    worst
}

#[test]
fn noises_of_scipy() {
    let reference = reference("sources_scipy");
    let series: Vec<Vec<f64>> =
        reference["series"].as_array().expect("two series").iter().map(numbers).collect();
    let step_s = reference["step_s"].as_f64().expect("a step");
    // Single ordinates, as SciPy has them.
    let spectra = CrossSpectra::of_whole(&[&series[0], &series[1]], step_s, 0.0).expect("spectra");
    let three = Mixture { spectra: &spectra, step_s, columns: columns(0), known: Vec::new() };
    let three = compare(&fit(&three).expect("a fit"), 0, step_s, &reference["three"]);

    let [log, alpha, white] = numbers(&reference["known"])[..] else { panic!("three numbers") };
    let density = |f: &f64| log.exp() * f.powf(-alpha) + 2.0 * step_s * white.exp();
    let first = KnownNoise {
        columns: columns(0)[..1].to_vec(),
        densities: vec![spectra.frequency_hz.iter().map(density).collect()],
        relative_std: reference["factor_std"].as_f64().expect("a std"),
    };
    let known = Mixture { spectra: &spectra, step_s, columns: columns(1), known: vec![first] };
    let known = compare(&fit(&known).expect("a fit"), 1, step_s, &reference["first_known"]);
    // The last step of the fit is below 1e-5 standard errors.
    assert!(three[0] < 1e-4 && known[0] < 1e-4, "{three:?} {known:?}");
    assert!(three[1] < 1e-3 && known[1] < 1e-3, "{three:?} {known:?}");
}

/// White noise alone: the levels are those of the three-cornered hat where these are positive, no instrument
/// has less than none, and an instrument that shares its noise with another shows in the goodness.
#[test]
fn white_noises_and_what_is_not_independent() {
    let mut stream = Stream::new(11, "sources");
    let rows = 4096;
    let levels = [1.0, 0.02, 2.0];
    let noises = levels.map(|level| white(&mut stream, rows, level));
    let common = white(&mut stream, rows, 1.5);
    let minus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
    let (second, third) = (minus(&noises[1], &noises[0]), minus(&noises[2], &noises[0]));
    let fitted = |series: [&[f64]; 2]| {
        let spectra = CrossSpectra::of_whole(&series, 1.0, 0.05).expect("spectra");
        fit(&Mixture { spectra: &spectra, step_s: 1.0, columns: columns(0), known: Vec::new() })
            .expect("a fit")
    };
    let found = fitted([&second, &third]);
    let covariance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / rows as f64;
    let hat = [
        covariance(&second, &third),
        covariance(&second, &second) - covariance(&second, &third),
        covariance(&third, &third) - covariance(&second, &third),
    ];
    for (i, source) in found.sources.iter().enumerate() {
        let rms = source.white_rms;
        if i == 1 {
            assert!(rms.value < 0.2 && rms.std > 0.02, "a good instrument among bad ones is not well known");
        } else {
            assert!((rms.value / hat[i].sqrt() - 1.0).abs() < 0.05, "{rms:?} {hat:?}");
            assert!((rms.value - levels[i]).abs() < 4.0 * rms.std, "{rms:?}");
        }
    }
    assert!(found.goodness > 1e-3);
    // A delayed copy of one noise in two series is nobody's own.
    let late: Vec<f64> = (0..rows).map(|i| if i == 0 { 0.0 } else { common[i - 1] }).collect();
    let plus = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect::<Vec<f64>>();
    assert!(fitted([&plus(&second, &common), &plus(&third, &late)]).goodness < 1e-6);
}
