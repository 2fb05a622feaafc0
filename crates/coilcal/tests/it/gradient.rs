//! Surveys along a coil's axis against what is true.

use common::Axis;
use serde_json::{Value, json};

use crate::build::{calibrated, simulated};

fn plan(seed: u64) -> Value {
    json!({
        "fluxcal": 1,
        "seed": seed,
        "facility": {"coils": {"z": {"max_nt": 60000}}, "reference_std_nt": 0.1},
        "calibration": {"coils": {"z": {"constant_nt_per_a": 43000}}},
        "truth": {"coil_profile": {"z": {"first_ppm_per_m": 2.0, "second_ppm_per_m2": -32.0, "fourth_ppm_per_m4": -40.0}}},
        "procedures": [{"procedure": "coil_gradient", "id": "survey", "coil": "z"}]
    })
}

#[test]
fn intervals_of_the_terms_cover() {
    // 60 000 nT · (2, −32, −40) ppm; the error within 0.05 m is at its end: 2 · 0.05 + 32 · 0.0025 + … ppm on
    // the low side.
    let truth = [60_000.0, 0.12, -1.92, -2.4];
    let error = 60_000.0 * (2.0 * 0.05 + 32.0 * 0.05f64.powi(2) + 40.0 * 0.05f64.powi(4)) * 1e-6;
    let mut covered = [0u32; 5];
    for seed in 0..300 {
        let found = calibrated(simulated(&plan(seed)));
        let survey = &found.coil(Axis::Z).expect("coil z").surveys[0];
        let off = survey.off_centre.as_ref().expect("an error");
        let quantities =
            [&survey.centre_nt, &survey.first_nt_per_m, &survey.second_nt_per_m2, &survey.fourth_nt_per_m4];
        for (number, quantity) in quantities.into_iter().enumerate() {
            let quantity = quantity.as_ref().expect("a term");
            // 70 readings, four terms: Student's t for 66.
            covered[number] += u32::from(
                (quantity.value() - truth[number]).abs() <= 1.9966 * quantity.std().expect("a std"),
            );
        }
        covered[4] +=
            u32::from((off.error_nt.value() - error).abs() <= 1.9966 * off.error_nt.std().expect("a std"));
        assert!((survey.noise_nt / 0.1 - 1.0).abs() < 0.4);
        assert!((survey.worst_position_m.abs() - 0.4572).abs() < 1e-9);
    }
    println!("{covered:?} of 300");
    // The error within a distance is a maximum, and so a little too large where noise decides its place.
    assert!(covered[..4].iter().all(|count| (274..=296).contains(count)), "{covered:?}");
}
