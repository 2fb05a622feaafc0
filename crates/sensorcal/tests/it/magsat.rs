//! The whole campaign of the report, simulated, calibrated, and held against what was true.

use common::{Axis, Quantity};
use simulate::Campaign;

use crate::build::{self, coefficients, true_effect};

#[test]
fn every_true_coefficient_is_within_its_interval() {
    let Campaign { document, truth, .. } = build::simulated(&build::magsat());
    let found = build::calibrated(coilcal::run(document, &coilcal::Options::default()).expect("the coils"));
    let mut missed: Vec<(String, f64)> = Vec::new();
    for axis in Axis::ALL {
        let sensor = build::of(&found, axis);
        let true_sensor = truth.calibration.sensor(axis).expect("a sensor");
        let mut add = |name: &str, quantity: &Quantity, truth: f64| {
            missed.push((
                format!("{axis} {name}"),
                (quantity.value() - truth) / quantity.std().expect("a std"),
            ));
        };
        let k = true_sensor.sensitivity_nt_per_v.as_ref().expect("k").value();
        add("k", sensor.sensitivity_nt_per_v.as_ref().expect("k"), k);
        // An offset that ages by r each day reads r t more field: O falls.
        let ageing = true_effect(&truth, "ageing", axis, "rate_nt_per_day");
        let offset = true_sensor.offset_nt.as_ref().expect("O").value();
        let days = 6.0;
        add("O", sensor.offset_nt.as_ref().expect("O"), offset - ageing * days);
        for (name, quantity, truth) in coefficients(sensor, &truth, axis).concat() {
            add(&name, quantity, truth);
        }
        let cross = sensor.cross_field.as_ref().expect("transverse fields");
        let significant = cross.significance.expect("a test").p_value < 0.01;
        assert_eq!(significant, axis == Axis::X, "sensor {axis}: transverse fields");
        let noise = sensor.noise.as_ref().expect("noise");
        add("A", &noise.flicker_nt2_per_hz_at_1hz, 9.786e-5);
        add("alpha", &noise.flicker_exponent, 1.0);
        add("white", &noise.white_rms_nt, 0.02);
        let drift = sensor.drift.as_ref().expect("a drift");
        add("trend", drift.trend_nt_per_year.as_ref().expect("a trend"), -ageing * 365.25);
        assert!(sensor.budget.iter().all(|budget| budget.standard_nt < 1.0), "within 1 nT up to full field");
    }
    let outside = missed.iter().filter(|(_, by)| by.abs() > 1.96).count();
    for (name, by) in &missed {
        println!("{name}: {by:+.2} standard uncertainties");
    }
    println!("{outside} of {} outside their 95 % intervals", missed.len());
    // One in twenty may be outside, give or take; none by more than chance allows for so many.
    assert!(outside as f64 <= 0.05 * missed.len() as f64 + 4.0, "{outside} of {}", missed.len());
    assert!(missed.iter().all(|(_, by)| by.abs() < 3.6), "{missed:?}");
    let adopted = &found.model.as_ref().expect("a model").effects;
    let across = adopted.iter().filter(|effect| effect.effect.starts_with("cross_field")).count();
    assert_eq!((adopted.len(), across), (12 + 2, 2));
    let words = sensorcal::summary(&found);
    assert!(words.lines().count() < 60 && words.contains("sensorcal: sensor x: 6401."), "{words}");
}
