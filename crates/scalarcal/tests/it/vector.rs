//! Twelve parameters by a known field and the attitude, in orbit. FLUXCAL_CAMPAIGNS sets how many campaigns.

use common::{Axis, Noise, uncertainty};
use scalarcal::Options;
use simulate::{KnownField, Plan, Procedure};

use crate::build::{change, constants, directions, findings, found, intervals_hold, run, told};
use crate::orbit::{BAND, LONGER, recorded};

/// What is beside the readings.
#[derive(Clone, Copy)]
struct Beside {
    scalar: bool,
    white_nt: f64,
    flicker: f64,
    attitude_arcsec: f64,
}

const MODEL: Beside = Beside { scalar: false, white_nt: 5.0, flicker: 0.0, attitude_arcsec: 20.0 };

/// Six hours, one row a minute.
fn plan(seed: u64, beside: Beside) -> Plan {
    let mut plan = Plan::parse(&testkit::read_fixture("plans/orbit.json")).expect("a plan");
    plan.seed = seed;
    let Some(Procedure::Orbit(orbit)) = plan.procedures.first_mut() else { panic!("an orbit first") };
    (orbit.step_s, orbit.length_s) = (60.0, 6.0 * 3600.0 * LONGER as f64);
    (orbit.libration_deg, orbit.yaw_period_s, orbit.scalar) = (12.0, Some(7000.0), beside.scalar);
    let noise = Noise {
        white_rms_nt: Some(beside.white_nt),
        flicker_nt2_per_hz_at_1hz: (beside.flicker > 0.0).then_some(beside.flicker),
        ..Noise::default()
    };
    orbit.known_field = Some(KnownField { noise, attitude_std_arcsec: beside.attitude_arcsec });
    plan
}

/// The paths of sensitivities, offsets, and of each sensor the two cosines across it.
fn paths() -> Vec<String> {
    let directions = uncertainty::directions("sensors");
    let across = (0..9).filter(|k| k % 4 != 0).map(|k| directions[k].clone());
    let ks = Axis::ALL.map(|axis| uncertainty::sensitivity(axis, "v"));
    ks.into_iter().chain(Axis::ALL.map(uncertainty::sensor_offset)).chain(across).collect()
}

/// Their values in a calibration.
fn values(calibration: &common::Calibration) -> Vec<f64> {
    let column = directions(calibration);
    let across = (0..9).filter(|k| k % 4 != 0).map(|k| column[k / 3][k % 3]);
    constants(calibration).into_iter().chain(across).collect()
}

fn vector() -> Options {
    Options { vector: true, ..Options::default() }
}

fn covered(name: &str, beside: Beside, usual: u64) {
    let paths = paths();
    let names: Vec<&str> = paths.iter().map(String::as_str).collect();
    intervals_hold(name, &names, (usual, BAND), |seed| {
        let plan = plan(seed, beside);
        let truth = values(plan.truth.calibration.as_ref().expect("a truth"));
        let calibration = run(recorded(&plan), &vector()).calibration.expect("a calibration");
        let joint = calibration.uncertainty.as_ref().expect("sources");
        let found = values(&calibration).into_iter().zip(truth).zip(&paths);
        found.map(|((value, truth), path)| (value - truth, joint.std(path))).collect()
    });
}

#[test]
fn by_a_model_of_the_field() {
    covered("model", MODEL, 12);
}

#[test]
fn by_a_model_whose_errors_have_memory() {
    covered("model with memory", Beside { flicker: 1.0, white_nt: 2.0, ..MODEL }, 4);
}

#[test]
fn by_a_model_beside_a_scalar_magnetometer() {
    covered("scalar and model", Beside { scalar: true, ..MODEL }, 8);
}

#[test]
fn a_model_that_is_poor_does_not_bias() {
    covered("poor model", Beside { white_nt: 2000.0, attitude_arcsec: 2000.0, ..MODEL }, 4);
}

#[test]
fn swapped_and_mirrored_axes_are_told() {
    for scalar in [false, true] {
        let plan = plan(3, Beside { scalar, ..MODEL });
        let truth = values(plan.truth.calibration.as_ref().expect("a truth"));
        assert_eq!(findings(&run(recorded(&plan), &vector())), "");
        let mut swapped = recorded(&plan);
        let columns = &mut swapped.recordings[0].columns;
        let [x, y] = ["sensor_x_v", "sensor_y_v"].map(|name| columns[name].clone());
        columns.insert("sensor_x_v".into(), y);
        columns.insert("sensor_y_v".into(), x);
        let swapped = run(swapped, &vector());
        assert!(findings(&swapped).contains("sensors x and y are swapped"), "{}", findings(&swapped));
        let found = values(swapped.calibration.as_ref().expect("a calibration"));
        assert!((found[0] - truth[1]).abs() < 1.0 && (found[1] - truth[0]).abs() < 1.0, "{found:?}");
        let mut mirrored = recorded(&plan);
        change(&mut mirrored, "sensor_z_v", |_, value| -value);
        let mirrored = run(mirrored, &vector());
        assert!(findings(&mirrored).contains("sensor z reads the field with the opposite sign"));
        let found = values(mirrored.calibration.as_ref().expect("a calibration"));
        assert!((found[2] - truth[2]).abs() < 1.0 && (found[5] + truth[5]).abs() < 2.0, "{found:?}");
    }
}

#[test]
fn an_inverse_attitude_is_told() {
    let mut document = recorded(&plan(4, MODEL));
    for name in ["attitude_x", "attitude_y", "attitude_z"] {
        change(&mut document, name, |_, value| -value);
    }
    let message = told(scalarcal::run(document, &vector()));
    assert!(message.contains("inverse of the attitude"), "{message}");
}

#[test]
fn a_field_without_attitude_is_refused() {
    let mut document = recorded(&plan(5, MODEL));
    document.recordings[0].columns.shift_remove("attitude_w");
    let message = told(scalarcal::run(document, &vector()));
    assert!(message.contains("attitude_w"), "{message}");
}

#[test]
fn beside_a_scalar_magnetometer_the_nine_stay() {
    let document = recorded(&plan(7, Beside { scalar: true, flicker: 1.0, ..MODEL }));
    let plain = run(document.clone(), &Options::default());
    let (plain, with) = (found(&plain), found(&run(document, &vector())));
    assert_eq!((plain.len(), with.len()), (9, 12));
    for ((a, std), (b, other)) in plain.iter().zip(&with) {
        assert!((a - b).abs() < 1e-6 * std && (std / other - 1.0).abs() < 1e-6, "{a} {b} {std} {other}");
    }
}
