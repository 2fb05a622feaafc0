//! What the plans of the fixtures make is read: their drives stay within the scalar magnetometer's range.

use coilcal::Options;

#[test]
fn campaigns_of_plans_are_read() {
    let options = Options { off_centre_m: 0.05, nyquist_hz: 50.0 };
    for name in ["cubesat", "magsat"] {
        let plan =
            simulate::Plan::parse(&testkit::read_fixture(&format!("plans/{name}.json"))).expect("a plan");
        let document = simulate::campaign(&plan).expect("simulated").document;
        let found = coilcal::run(document, &options).unwrap_or_else(|error| panic!("{name}: {error}"));
        let coils = found.calibration.and_then(|calibration| calibration.coils).expect("coils");
        assert!(coils.z.is_some_and(|coil| coil.constant_nt_per_a.is_some()), "{name}");
    }
}
