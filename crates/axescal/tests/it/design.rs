//! The proof of `axescal design`: the plan that it writes is simulated; axescal reaches what it predicts.

use axescal::design::{self, Request};
use common::{Axis, OneOrEach};
use physics::frames::{ARCSEC, angle, cube_rotations};
use serde_json::{Value, json};

use crate::build::{axes, columns, simulated, solved};
use crate::coverage::draw;

/// Coils of unlike strength, theodolites that share an error, noise with memory, and codes.
fn basis() -> Value {
    let mut basis = design::ordinary();
    for (axis, field) in [("x", 40_000.0), ("y", 15_000.0), ("z", 50_000.0)] {
        basis["facility"]["coils"][axis]["max_nt"] = json!(field);
    }
    basis["facility"]["theodolite_shared_arcsec"] = json!(0.5);
    basis["instrument"]["quantisation_v"] = json!(1e-5);
    basis["instrument"]["noise"] = json!({"white_rms_nt": 0.05, "flicker_nt2_per_hz_at_1hz": 4e-4});
    basis
}

#[test]
fn what_is_predicted_is_stated_and_reached() {
    let basis = basis();
    let given = design::given(&basis).expect("given");
    let request = Request { target_arcsec: 1.0, confidence: 0.95, coils: true };
    let plan = design::plan(&given, &cube_rotations(), request).expect("a design");
    let shares: f64 = plan.limits.iter().map(|limit| limit.share).sum();
    assert!((shares - 1.0).abs() < 1e-3, "{shares}");
    assert!(plan.predicted.worst_arcsec <= 1.0);
    let most = plan.predicted.worst_arcsec + 1e-9;
    assert!(plan.more.iter().all(|more| more.worst_arcsec <= most), "{:?}", plan.more);
    let reached = plan.table.iter().filter_map(|cost| cost.reached.as_ref());
    let hours: Vec<f64> = reached.map(|reached| reached.hours).collect();
    assert!(hours.len() >= 3 && hours.is_sorted(), "{hours:?}");

    let proof = design::proof(&basis, &plan.procedure);
    let proof = simulate::Plan::parse(&proof.to_string()).expect("a plan");
    let sheet = simulate::run_sheet(&proof).expect("a run sheet");
    assert!((sheet.work_s / 3600.0 - plan.hours.total).abs() < 1e-6, "{} h", sheet.work_s / 3600.0);
    let campaigns = testkit::campaigns(20) as usize;
    let (mut inside, mut tried, mut farthest) = (0, 0, 0.0_f64);
    for campaign in 0..campaigns {
        let simulate::Campaign { document, truth } = simulated(&draw(&proof, campaign));
        let document = solved(document);
        let found = axes(&document);
        let meant = truth.calibration.axes.as_ref().expect("true axes");
        let declared = found.fit.as_ref().is_some_and(|fit| fit.noise_source == "declared");
        for (predicted, found, meant) in [
            (&plan.predicted.sensors, &found.sensors, &meant.sensors),
            (&plan.predicted.coils, &found.coils, &meant.coils),
        ] {
            for axis in Axis::ALL {
                let get = |all: &OneOrEach| all.get(axis).expect("each");
                let column = |part| columns(part).column(axis.index()).into_owned();
                let off = angle(&column(found), &column(meant)) / ARCSEC;
                inside += usize::from(off <= get(&predicted.within_arcsec));
                tried += 1;
                if declared {
                    let stated = found.as_ref().and_then(|part| part.std_arcsec.as_ref());
                    let stated = get(stated.expect("stated"));
                    farthest = farthest.max((stated / get(&predicted.std_arcsec) - 1.0).abs());
                }
            }
        }
    }
    println!(
        "{campaigns} campaigns of {} settings, {:.1} h: {inside} of {tried} directions within what is predicted with 95 %; stated \
         uncertainties within {:.1} % of the predicted ones",
        plan.recordings.settings,
        plan.hours.total,
        100.0 * farthest
    );
    assert!(farthest < 0.05, "{farthest}");
    // Directions of one campaign go together: judged as a quarter as many.
    let (inside, tried) = (inside / 4, tried / 4);
    assert!(testkit::agrees(inside, tried, [0.93, 0.97], 1), "{inside} of {tried}");
}

#[test]
fn temperatures_count_and_a_target_out_of_reach_is_refused() {
    let magsat: Value = serde_json::from_str(&testkit::read_fixture("plans/magsat.json")).expect("JSON");
    let mut given = design::given(&magsat).expect("given");
    // Thirteen levels, of sensor and electronics, for each of three sensors.
    assert_eq!(given.times.temperature_levels, 78);
    assert_eq!(given.coil_nt, [25_000.0, 6_000.0, 60_000.0]);
    given.theodolite_shared_arcsec = 20.0;
    let request = Request { target_arcsec: 0.5, confidence: 0.95, coils: false };
    let refused = design::plan(&given, &cube_rotations(), request).expect_err("out of reach").to_string();
    assert!(refused.contains("0.5\" for the sensors") && refused.contains("out of reach"), "{refused}");
    // Theodolites by which nothing is determined end the search too.
    given.theodolite_arcsec = 1e12;
    let refused = design::plan(&given, &cube_rotations(), request).expect_err("undetermined").to_string();
    assert!(refused.contains("out of reach"), "{refused}");
}
