//! Numbers from outside: a campaign of the basic chain and fourteen kinds of effects, recomputed by
//! fixtures/reference/campaign_scipy.py with SciPy's ODE solver.

#[test]
fn scipy_gives_the_same_readings() {
    let plan = testkit::read_fixture("reference/campaign_plan.json");
    let plan = simulate::Plan::parse(&plan).expect("a plan");
    let expected = testkit::reference::reference("campaign_scipy");
    let document = simulate::campaign(&plan).expect("simulated").document;
    let mut worst = 0.0f64;
    let mut readings = 0;
    for recording in &document.recordings {
        for axis in ["x", "y", "z"] {
            let theirs = expected["readings_nt"][&recording.id][axis].as_array().expect("a list");
            let ours = recording.column(&format!("sensor_{axis}_nt")).expect("readings");
            assert_eq!(ours.len(), theirs.len());
            for (row, (ours, theirs)) in ours.iter().zip(theirs).enumerate() {
                let missed = (ours - theirs.as_f64().expect("a number")).abs();
                assert!(missed < 1e-6, "{} sensor {axis} row {row}: {missed} nT", recording.id);
                worst = worst.max(missed);
                readings += 1;
            }
        }
    }
    println!("{readings} readings, the worst {worst:.1e} nT from SciPy");
    assert_eq!(readings, 933);
}
