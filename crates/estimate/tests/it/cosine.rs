//! Regression by cosine transforms against generalised least squares with the full covariance matrix
//! (fixtures/reference/diffmag_drift.py).

use estimate::cosine::{Cosine, Errors, Projection, regress, weighted};
use estimate::periodogram::{Bin, Periodogram};
use estimate::spectral;
use estimate::whittle::{self, Estimate, WhittleFit};
use testkit::reference::{list, number, reference};

/// A fit of A, α and white noise with these values.
fn noise(exponent: f64, white: f64) -> WhittleFit {
    let bin = |k: u32| Bin { frequency_hz: f64::from(k), density: 1.0 / f64::from(k), count: 1.0 };
    let ordinates = Periodogram {
        length_s: 1.0,
        step_s: 1.0,
        samples: 100,
        bins: (1..50).map(bin).collect(),
        lines: Vec::new(),
        mirrored: false,
    };
    let mut fit = whittle::fit(&[ordinates]).expect("a fit");
    fit.amplitude = Estimate { value: 1.0, std: 0.1 };
    fit.exponent = Estimate { value: exponent, std: 0.1 };
    fit.white_variances = vec![white];
    fit
}

#[test]
fn variances_of_slow_columns() {
    let reference = &reference("diffmag_drift")["slow"];
    let rows = number(&reference["rows"]) as usize;
    let cosine = Cosine::new(rows, 1.0);
    for case in list(&reference["cases"]) {
        let noise = noise(number(&case["exponent"]), number(&case["white"]));
        let errors = Errors::of(&noise, &cosine).expect("errors");
        let time = |row: usize| row as f64 / rows as f64;
        let tau = number(&case["tau"]);
        let columns = [
            cosine.transform(&(0..rows).map(time).collect::<Vec<_>>()),
            cosine.transform(&(0..rows).map(|row| (-time(row) / tau).exp()).collect::<Vec<_>>()),
        ];
        let found = weighted(&[&columns[0], &columns[1]], &columns[0], &errors).expect("a fit");
        // Over the variance of the full covariance: never too small, and too great by what `Errors::of` says.
        let [line, exponential] = [0, 1].map(|i| found.covariance[(i, i)] / number(&case["variance"][i]));
        assert!(line > 0.98 && line < 1.03, "{case}: {line}");
        assert!(exponential > 0.98 && exponential < 1.15, "{case}: {exponential}");
    }
}

#[test]
fn independent_errors_give_least_squares() {
    for rows in [96, 97] {
        let wave =
            |rate: f64| -> Vec<f64> { (0..rows).map(|i| 300.0 + (rate * f64::from(i)).sin()).collect() };
        let columns = vec![wave(0.13), wave(0.031)];
        let y: Vec<f64> = (0..rows)
            .map(|i| {
                0.9 * columns[0][i as usize] - 0.2 * columns[1][i as usize] + 0.01 * f64::from((i * 37) % 11)
            })
            .collect();
        // P = 2 σ² Δt with σ = 0.5.
        let plain = spectral::regress(&columns, &y, 1.0, &|_| 2.0 * 0.25).expect("a fit");
        assert!(spectral::regress(&[vec![1.0; y.len()]], &y, 1.0, &|_| 1.0).is_err());
        let cosine = Cosine::new(rows as usize, 1.0);
        let x = [cosine.transform(&columns[0]), cosine.transform(&columns[1])];
        let transformed = cosine.transform(&y);
        let errors = Errors::independent(&cosine);
        let fit = regress(&[&x[0], &x[1]], &transformed, &errors).expect("a fit");
        for i in 0..2 {
            assert!((fit.least_squares[i] - plain.least_squares[i]).abs() < 1e-11);
            assert!((fit.weighted[i] - plain.least_squares[i]).abs() < 1e-11);
            for covariance in [&plain.covariance, &plain.weighted_covariance] {
                assert!((covariance[(i, i)] / (0.25 * plain.independent[(i, i)]) - 1.0).abs() < 1e-6);
            }
            for covariance in [&fit.independent, &fit.covariance, &fit.weighted_covariance] {
                assert!((covariance[(i, i)] / plain.independent[(i, i)] - 1.0).abs() < 1e-9);
            }
        }
        // The score of the last column beside the others is its coefficient over its standard deviation.
        let projection = Projection::of(&[&x[0]], &transformed, &errors).expect("a base");
        let score = projection.score(&projection.direction(&x[1], &errors).expect("a direction"));
        let expected = fit.weighted[1] / fit.weighted_covariance[(1, 1)].sqrt();
        assert!((score - expected).abs() < 1e-9 * expected.abs());
        assert!(projection.direction(&x[0], &errors).is_none());
    }
}
