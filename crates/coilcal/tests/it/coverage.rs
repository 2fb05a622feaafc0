//! Coverage of k and B0 over simulated campaigns, resistor and voltmeter erring once for each. FLUXCAL_CAMPAIGNS sets how many.

use common::{Axis, Budget, Quantity};
use serde_json::json;

fn campaigns() -> u64 {
    testkit::campaigns(200)
}

fn plan(seed: u64) -> simulate::Plan {
    let plan = json!({
        "fluxcal": 1,
        "seed": seed,
        "facility": {
            "coils": {"z": {"resistor_ohm": 5.0, "resistor_relative_uncertainty": 2e-6, "max_nt": 60000}},
            "voltmeter": {"absolute_v": 2e-5, "relative": 1e-6}, "reference_std_nt": 0.5, "reference_range_nt": [15000, 65000]},
        "calibration": {"coils": {"z": {"constant_nt_per_a": 43000}}},
        "unstated": ["coils"],
        "drive": "voltage",
        "truth": {"calibration": {"coils": {"z": {"constant_nt_per_a": 43021.9, "offset_nt": 0.7}}}},
        "procedures": [{"procedure": "coil_constant", "id": "coil", "coil": "z", "repeats": 4}]
    });
    simulate::Plan::parse(&plan.to_string()).expect("a plan")
}

#[test]
fn intervals_cover_and_would_not_without_the_common_errors() {
    let count = campaigns();
    // For constant and offset: covered by the joint uncertainty, covered by type A alone.
    let mut covered = [[0u64; 2]; 2];
    for seed in 0..count {
        let simulate::Campaign { document, .. } = simulate::campaign(&plan(seed)).expect("simulated");
        let found = coilcal::run(document, &coilcal::Options::default())
            .expect("calibrated")
            .calibration
            .expect("a calibration");
        let coil = found.coil(Axis::Z).expect("coil z");
        let fit = coil.constant.as_ref().expect("a fit");
        let values =
            [(&coil.constant_nt_per_a, "constant_nt_per_a", 43021.9), (&coil.offset_nt, "offset_nt", 0.7)];
        for (number, (quantity, key, truth)) in values.into_iter().enumerate() {
            let quantity: &Quantity = quantity.as_ref().expect("a quantity");
            let Budget { type_a, type_b } = fit.uncertainty[key];
            let std = quantity.std().expect("a std");
            assert!((std - type_a.hypot(type_b)).abs() < 1e-12 * std && type_b > 0.0);
            let missed = (quantity.value() - truth).abs();
            covered[number][0] += u64::from(missed <= fit.coverage_factor_95 * std);
            covered[number][1] += u64::from(missed <= fit.coverage_factor_95 * type_a);
        }
    }
    for (key, [joint, alone]) in ["constant", "offset"].iter().zip(covered) {
        let share = |covered: u64| covered as f64 / count as f64;
        println!(
            "{key}: {:.1} % of {count}, without the common errors {:.1} %",
            100.0 * share(joint),
            100.0 * share(alone)
        );
        // 93 to 97 %, widened by three standard deviations of the binomial for fewer campaigns than 1 000.
        let slack = if count < 1000 { 3.0 * (0.95 * 0.05 / count as f64).sqrt() } else { 0.0 };
        assert!((0.93 - slack..=0.97 + slack).contains(&share(joint)), "{key}: {}", share(joint));
        assert!(share(alone) < 0.9, "{key}: {}", share(alone));
    }
}
