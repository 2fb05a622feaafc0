//! Simulated pairs in the natural field.

use serde_json::{Value, json};

/// A pair at a middle latitude on a quiet day, with the variations of its background.
pub fn plan(seed: u64, noise: &Value, days: f64) -> Value {
    json!({
        "fluxcal": 1,
        "seed": seed,
        "start": "2026-03-01T00:00:00Z",
        "instrument": {"noise": noise},
        "truth": {
            "outside": {
                "main_field_nt": [20800, 700, 47500],
                "daily_nt": [22, 28, 12],
                "background": {"flicker_nt2_per_hz_at_1hz": 2e-4, "flicker_exponent": 1.6}
            },
            "differential": {
                "reference": {"alpha_deg": 25.0, "beta_deg": 0.31, "gamma_deg": 0.22, "scale": [1.0012, 0.9985, 1.0007]},
                "test": {"phi_deg": [91.1, 0.9, 40.0], "theta_deg": [89.6, 90.4, 0.35], "scale": [0.9991, 1.0016, 0.9979]},
                "offset_nt": [12.0, -7.5, 21.0]
            }
        },
        "procedures": [{"procedure": "differential", "id": "pair", "length_s": days * 86_400.0, "step_s": 60}]
    })
}

/// The plan of a pair at an observatory with a storm, whose reference is noisy: of so many days, the storm in
/// the middle.
pub fn observatory_pair(days: f64) -> Value {
    let plan = testkit::read_fixture("plans/observatory-pair.json");
    let mut plan: Value = serde_json::from_str(&plan).expect("a plan");
    plan["procedures"][0]["length_s"] = json!(days * 86_400.0);
    plan["truth"]["outside"]["storm"]["time_s"] = json!(0.5 * days * 86_400.0);
    plan
}

pub fn simulated(plan: &Value) -> simulate::Campaign {
    simulate::campaign(&simulate::Plan::parse(&plan.to_string()).expect("a plan")).expect("simulated")
}
