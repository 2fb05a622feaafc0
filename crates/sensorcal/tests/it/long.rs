//! Fits of many readings: FLUXCAL_ROWS sets how many (5 000).

use serde_json::json;

use crate::build::{K, found, near, sensitivity, sensor, with};

fn rows() -> usize {
    testkit::number("FLUXCAL_ROWS").map_or(5_000, |rows| rows as usize)
}

#[test]
fn a_long_sweep_is_fitted() {
    let fields: Vec<f64> = (0..rows()).map(|row| 50_000.0 * ((row % 101) as f64 / 50.0 - 1.0)).collect();
    let mut document = with(vec![sensitivity(31, &fields, 0.1, |b| b + 2.0 * (b / 5e4).powi(2))]);
    document["instrument"]["noise"] = json!({"white_rms_nt": 0.1});
    let sensor = sensor(&document);
    let k = sensor.sensitivity_nt_per_v.expect("k");
    assert!(near(&k, K, 4.0), "{k:?}");
    let fit = sensor.sensitivity.expect("a fit");
    assert_eq!(found(&fit.departures), ["quadratic_nonlinearity"]);
    // White noise of 0.1 nT over fields of 29 000 nT rms.
    let expected = K * 0.1 / (29_150.0 * (rows() as f64).sqrt());
    assert!((k.std().expect("a std") / expected - 1.0).abs() < 0.1, "{k:?} {expected}");
}
