//! Newey-West covariances against statsmodels (fixtures/reference/hac_statsmodels.py).

use estimate::{hac, linear};
use faer::Mat;
use testkit::reference::{list, number, numbers, reference};

#[test]
fn as_statsmodels_has_them() {
    let mut worst: f64 = 0.0;
    for case in list(&reference("hac_statsmodels")["cases"]) {
        let y = numbers(&case["y"]);
        let time = |row: usize| row as f64 * 7.0 / 365.25;
        let middle = time(y.len() - 1) / 2.0;
        let design = Mat::from_fn(y.len(), 4, |row, column| {
            let angle = std::f64::consts::TAU * time(row);
            [1.0, time(row) - middle, angle.cos(), angle.sin()][column]
        });
        let fit = linear::fit(design.as_ref(), &y, None).expect("a fit");
        let columns: Vec<&[f64]> = (0..4).map(|j| design.col_as_slice(j)).collect();
        let lags = number(&case["lags"]) as usize;
        let covariance = hac::newey_west(&columns, &fit.residuals, fit.covariance.as_ref(), lags);
        for (i, row) in list(&case["covariance"]).iter().enumerate() {
            for (j, expected) in numbers(row).into_iter().enumerate() {
                let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
                worst = worst.max((covariance[(i, j)] - expected).abs() / scale);
            }
        }
    }
    assert!(worst < 1e-10, "{worst:.1e} standard deviations");
    assert_eq!((hac::lags(100), hac::lags(53), hac::lags(10_000)), (4, 3, 11));
}
