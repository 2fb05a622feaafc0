//! Spectral matrices against SciPy's csd, and their degrees of freedom against the scatter of white noise.

use estimate::Error;
use estimate::cross_spectrum::CrossSpectra;
use noise::Stream;
use serde_json::Value;
use testkit::reference::{list, number, numbers, reference};

use crate::made::white;

/// The largest difference, as a share of the roots of both densities.
fn compare(found: &CrossSpectra, expected: &Value) -> f64 {
    let frequency = numbers(&expected["frequency_hz"]);
    assert_eq!(found.frequency_hz.len(), frequency.len());
    assert_eq!(found.freedom.len(), frequency.len());
    for (found, expected) in found.frequency_hz.iter().zip(&frequency) {
        assert!((found / expected - 1.0).abs() < 1e-13, "{found} Hz, {expected} Hz");
    }
    let parts: Vec<[Vec<f64>; 2]> = list(&expected["matrices"])
        .iter()
        .map(|element| [numbers(&element["real"]), numbers(&element["imaginary"])])
        .collect();
    let mut worst = 0.0_f64;
    for (k, matrix) in found.matrices.iter().enumerate() {
        for i in 0..3 {
            for j in 0..3 {
                let size = (parts[4 * i][0][k] * parts[4 * j][0][k]).sqrt();
                let [real, imaginary] = &parts[3 * i + j];
                let off = (matrix[(i, j)].re - real[k]).hypot(matrix[(i, j)].im - imaginary[k]);
                worst = worst.max(off / size);
            }
        }
    }
    worst
}

#[test]
fn matrices_of_scipy() {
    let reference = reference("cross_spectrum_scipy");
    let mut worst = 0.0_f64;
    for set in list(&reference["sets"]) {
        let series: Vec<Vec<f64>> = list(&set["series"]).iter().map(numbers).collect();
        let channels: Vec<&[f64]> = series.iter().map(Vec::as_slice).collect();
        let step_s = number(&set["step_s"]);
        for expected in list(&set["tapered"]) {
            let (samples, tapers) =
                (number(&expected["samples"]) as usize, number(&expected["tapers"]) as usize);
            let found = CrossSpectra::of(&channels, step_s, samples, tapers).expect("spectra");
            let freedom = number(&expected["freedom"]);
            assert!((found.freedom[0] / freedom - 1.0).abs() < 1e-12, "{} {freedom}", found.freedom[0]);
            worst = worst.max(compare(&found, expected));
        }
        let found = CrossSpectra::of_whole(&channels, step_s, number(&reference["widest"])).expect("spectra");
        assert_eq!(found.freedom, numbers(&set["whole"]["freedom"]));
        worst = worst.max(compare(&found, &set["whole"]));
    }
    assert!(worst < 1e-11, "{worst:.1e}");
}

#[test]
fn white_noise_scatters_as_its_freedom_says() {
    let (step_s, std, mut stream) = (0.5, 0.3, Stream::new(5, "cross spectrum"));
    let truth = 2.0 * std * std * step_s;
    for (samples, tapers) in [(128, 1), (128, 4), (400, 6)] {
        let (mut sum, mut squares, mut count, mut freedom) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..600 {
            let series = white(&mut stream, 400, std);
            let found = CrossSpectra::of(&[&series], step_s, samples, tapers).expect("spectra");
            freedom = found.freedom[0];
            let far = found.frequency_hz.len() - tapers - 2;
            for matrix in found.matrices[tapers + 2..far].iter().step_by(2 * tapers) {
                let ratio = matrix[(0, 0)].re / truth;
                (sum, squares, count) = (sum + ratio, squares + ratio * ratio, count + 1.0);
            }
        }
        let mean = sum / count;
        let scattered = 2.0 * mean * mean / (squares / count - mean * mean);
        assert!((mean - 1.0).abs() < 5.0 * (2.0 / freedom / count).sqrt(), "{samples} {tapers}: {mean}");
        // The variance of a sample variance of χ²(ν)/ν is about (2 + 12/ν) of its square over the count.
        let most = 5.0 * ((2.0 + 12.0 / freedom) / count).sqrt();
        assert!((scattered / freedom - 1.0).abs() < most, "{samples} {tapers}: {scattered} for {freedom}");
    }
}

#[test]
fn what_has_no_spectrum_is_refused() {
    let (long, short) = (vec![1.0; 20], vec![1.0; 19]);
    assert!(matches!(CrossSpectra::of(&[&long, &short], 1.0, 8, 1), Err(Error::Series(_))));
    assert!(matches!(CrossSpectra::of(&[&[f64::NAN; 20]], 1.0, 8, 1), Err(Error::Series(_))));
    assert!(matches!(CrossSpectra::of(&[&long], 1.0, 7, 1), Err(Error::TooFew { .. })));
    assert!(matches!(CrossSpectra::of(&[&long], 1.0, 8, 0), Err(Error::TooFew { .. })));
    assert!(matches!(CrossSpectra::of_whole(&[&[1.0; 7]], 1.0, 0.1), Err(Error::TooFew { .. })));
    assert!(matches!(CrossSpectra::of_whole(&[], 1.0, 0.1), Err(Error::TooFew { .. })));
}
