//! What the plans of the fixtures make is read: their drives stay within the scalar magnetometer's range.

use crate::build::{calibrated, simulated};

#[test]
fn campaigns_of_plans_are_read() {
    for name in ["cubesat", "magsat"] {
        let plan = testkit::read_fixture(&format!("plans/{name}.json"));
        let plan = serde_json::from_str(&plan).expect("JSON");
        let coils = calibrated(simulated(&plan)).coils.expect("coils");
        assert!(coils.z.is_some_and(|coil| coil.constant_nt_per_a.is_some()), "{name}");
    }
}
