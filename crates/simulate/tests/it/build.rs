//! Plans of the fixtures without what is random, and plans that are refused.

use common::Axis;
use nalgebra::Matrix3;
use serde_json::Value;
use simulate::{Plan, Truth};

const SIMULATE: &str = env!("CARGO_BIN_EXE_simulate");

pub fn plan(name: &str) -> Plan {
    Plan::parse(&testkit::read_fixture(&format!("plans/{name}.json"))).expect("a plan")
}

/// A plan of which nothing is random, read with all digits.
pub fn quiet(name: &str) -> Plan {
    let mut plan = plan(name);
    let instrument = plan.instrument.as_mut().expect("an instrument");
    (instrument.noise, instrument.quantisation_v, instrument.quantisation_nt) = (None, None, None);
    if let Some(facility) = &mut plan.facility {
        (facility.voltmeter, facility.theodolite_arcsec, facility.reference_std_nt) = (None, None, None);
        for coil in Axis::ALL {
            let coil = facility.coils.as_mut().and_then(|coils| coils.entry(coil).as_mut());
            coil.into_iter().for_each(|coil| coil.resistor_relative_uncertainty = None);
        }
    }
    (plan.truth.site, plan.truth.offset_wander) = (None, None);
    if let Some(differential) = &mut plan.truth.differential {
        differential.reference_noise = None;
    }
    plan
}

/// Unit vectors along the true sensors, and along the coils, as columns; nominal where the truth has none.
pub fn axes(truth: &Truth) -> [Matrix3<f64>; 2] {
    let axes = truth.calibration.axes.as_ref().expect("axes");
    [&axes.sensors, &axes.coils].map(|part| {
        let rows = part.as_ref().and_then(|part| part.matrix.as_ref());
        rows.map_or_else(Matrix3::identity, physics::frames::matrix)
    })
}

/// Each fault of a plan, a path and what is set there in a line or more, is refused with what stands below it, and nothing
/// is written. Gives the number of faults.
pub fn refused(command: &str, plan: &Value, faults: &str) -> usize {
    let (mut faulty, mut told) = (plan.clone(), 0);
    for line in faults.trim().lines() {
        let Some(message) = line.strip_prefix("    ") else {
            let (path, value) = line.split_once(" = ").expect("a path and a value");
            let place = path.split('.').fold(&mut faulty, |place, key| match key.parse::<usize>() {
                Ok(index) => &mut place[index],
                Err(_) => &mut place[key],
            });
            *place = serde_json::from_str(value).expect("JSON");
            continue;
        };
        let folder = tempfile::tempdir().expect("a folder");
        let file = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_string();
        let arguments = [command, "--truth", &file("truth.json"), "-o", &file("document.json")];
        let run = testkit::run(SIMULATE, &arguments, &faulty.to_string());
        assert_eq!((run.code, run.stdout.as_str()), (2, ""), "{message}");
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0, "{message}");
        assert!(run.stderr.contains(message), "{}\nwhere this is expected:\n{message}", run.stderr);
        (faulty, told) = (plan.clone(), told + 1);
    }
    told
}
