//! Documents that depart from the plain case: each is answered rightly, or refused in words.

use axescal::Options;
use common::{Axis, Column, Document, PerAxis, Quantity};

use crate::build::{self, axes, procedure, refused, says, simulated, solved, worst_arcsec};

fn plan() -> simulate::Plan {
    let mut plan = build::plan("magsat-axes");
    plan.facility = None;
    plan.instrument.as_mut().expect("an instrument").noise =
        Some(serde_json::from_str(r#"{"white_rms_nt": 0.1}"#).expect("a noise"));
    plan
}

fn drives(plan: &mut simulate::Plan, names: &[&str]) {
    let procedure = procedure(plan);
    procedure.drives = names.iter().map(|name| simulate::Drive::Named((*name).into())).collect();
    procedure.theodolite_angles = false;
}

/// Swaps what two recordings say of their orientation.
fn swap(document: &mut Document, one: usize, other: usize) {
    let first = document.recordings[one].conditions.clone();
    document.recordings[one].conditions = document.recordings[other].conditions.clone();
    document.recordings[other].conditions = first;
}

/// Asserts that a residual field or an offset is found along an axis, within four standard uncertainties.
#[track_caller]
fn found(all: &Option<PerAxis<Quantity>>, axis: Axis, truth: f64) {
    let one = all.as_ref().and_then(|all| all.get(axis)).expect("a quantity");
    assert!((one.value() - truth).abs() < 4.0 * one.std().expect("an uncertainty"), "{one:?}");
}

/// Asserts that no direction is further off than this, arcsec.
#[track_caller]
fn within(document: &Document, truth: &simulate::Truth, most: f64) {
    let worst = worst_arcsec(document, truth);
    assert!(worst < most, "{worst} arcsec");
}

#[test]
fn a_stated_ambient_field_is_part_of_the_model() {
    let mut plan = plan();
    drives(&mut plan, &["x", "y", "z"]);
    plan.truth.residual_field_nt = Some([(Axis::X, 100.0), (Axis::Z, -40.0)].into_iter().collect());
    let simulate::Campaign { mut document, truth } = simulated(&plan);
    for recording in &mut document.recordings {
        recording.columns.insert("ambient_x_nt".into(), Column::from(vec![100.0; 3]));
        recording.conditions.extra.insert("ambient_z_nt".into(), (-40.0).into());
    }
    // The plan's coil and sensor constants have offsets of stated uncertainty; the field itself is exact.
    within(&solved(document), &truth, 2.0);
}

#[test]
fn constants_are_found_from_the_sensors_that_show_them() {
    let mut plan = plan();
    drives(&mut plan, &["zero", "x", "y", "z"]);
    plan.truth.residual_field_nt = Some([(Axis::X, 20.0)].into_iter().collect());
    let simulate::Campaign { mut document, truth } = simulated(&plan);
    for recording in &mut document.recordings {
        recording.columns.get_mut("sensor_x_v").expect("a column")[0] = f64::NAN;
    }
    let document = solved(document);
    within(&document, &truth, 2.0);
    found(&axes(&document).residual_field_nt, Axis::X, 20.0);
}

#[test]
fn sharp_and_blunt_priors_do_not_decide_the_rank() {
    for std in [1e-15, 1e-12, 1e-6, 1e3] {
        let simulate::Campaign { mut document, truth } = simulated(&plan());
        let calibration = document.calibration.as_mut().expect("constants");
        let sensor = calibration.sensors.as_mut().and_then(|sensors| sensors.x.as_mut()).expect("sensor x");
        sensor.offset_nt = Some(Quantity::new(3.1, std));
        let coil = calibration.coils.as_mut().and_then(|coils| coils.y.as_mut()).expect("coil y");
        coil.constant_nt_per_a = Some(Quantity::new(40987.2, std));
        let document = solved(document);
        within(&document, &truth, 2.0);
        let fit = axes(&document).fit.as_ref().expect("a fit");
        assert_eq!(fit.rank, fit.unknowns, "std {std}");
        let offset =
            axes(&document).offsets_nt.as_ref().and_then(|offsets| offsets.y.as_ref()).expect("an offset");
        assert!(offset.std().expect("an uncertainty") < 0.2);
    }
}

#[test]
fn noise_declared_for_one_sensor_only_is_not_mixed_with_a_guess() {
    let simulate::Campaign { mut document, truth } = simulated(&plan());
    let instrument = document.instrument.as_mut().expect("an instrument");
    instrument.noise = Some(serde_json::from_str(r#"{"x": {"white_rms_nt": 0.001}}"#).expect("a noise"));
    let document = solved(document);
    let found = axes(&document);
    assert!(says(&document, "one value for all"), "{:?}", found.findings);
    assert!((found.fit.as_ref().expect("a fit").noise_nt / 0.1 - 1.0).abs() < 0.2);
    assert!(found.doubtful.is_empty());
    within(&document, &truth, 2.0);
}

#[test]
fn readings_that_do_not_fit_are_not_called_a_want_of_orientations() {
    let mut document = simulated(&plan()).document;
    swap(&mut document, 1, 4);
    let error = refused(document);
    assert!(error.starts_with("the readings do not fit the model"), "{error}");
}

#[test]
fn the_advised_turn_is_the_one_that_helps() {
    // Three orientations about an axis 9° off the vertical: turns about x and y help, about z hardly.
    let mut plan = plan();
    drives(&mut plan, &["x", "y", "z"]);
    let tilted = nalgebra::Unit::new_normalize(nalgebra::Vector3::new(0.12, 0.1, 1.0));
    let list = [0.0, 90.0, 180.0f64]
        .map(|degrees| *nalgebra::Rotation3::from_axis_angle(&tilted, degrees.to_radians()).matrix())
        .map(|rotation| physics::frames::rows(&rotation));
    procedure(&mut plan).orientations = simulate::Orientations::List(list.to_vec());
    procedure(&mut plan).fixture_std_arcmin = 0.0;
    let error = refused(simulated(&plan).document);
    assert!(error.contains("rotations about one axis, (0.12, 0.10, 0.99) of the block"), "{error}");
    assert!(error.contains("turned by 90° about its x or y axis"), "{error}");
}

#[test]
fn settings_keep_visits_of_one_orientation_apart() {
    let mut document = simulated(&plan()).document;
    let mut again = document.recordings[0].clone();
    again.id = "again".into();
    document.recordings.push(again);
    let count = |document: &Document| axes(&solved(document.clone())).orientations.len();
    assert_eq!(count(&document), 7);
    document.recordings[7].conditions.setting = Some("second visit".into());
    assert_eq!(count(&document), 8);
}

#[test]
fn a_statement_that_the_readings_contradict_is_said_and_left_free() {
    // A residual field of 100 nT where 0.2 nT is stated, seen by zero and reversed drives.
    let mut field = plan();
    field.truth.residual_field_nt = Some([(Axis::X, 100.0)].into_iter().collect());
    let simulate::Campaign { mut document, truth } = simulated(&field);
    document.facility = Some(common::Facility { residual_field_std_nt: Some(0.2), ..Default::default() });
    let document = solved(document);
    assert!(says(&document, "put the residual field"), "{:?}", axes(&document).findings);
    found(&axes(&document).residual_field_nt, Axis::X, 100.0);
    within(&document, &truth, 2.0);

    // An offset 50 nT off where 0.3 nT is stated, and a coil constant 400 ppm off where 7 ppm are.
    let mut constants = plan();
    let mut calibration = constants.calibration.clone().expect("constants");
    let sensor = calibration.sensors.as_mut().and_then(|sensors| sensors.y.as_mut()).expect("sensor y");
    sensor.offset_nt = Some(Quantity::Bare(48.2));
    let coil = calibration.coils.as_mut().and_then(|coils| coils.x.as_mut()).expect("coil x");
    coil.constant_nt_per_a = Some(Quantity::Bare(41234.5 * 1.0004));
    calibration.axes = constants.truth.calibration.as_ref().and_then(|truth| truth.axes.clone());
    constants.truth.calibration = Some(calibration);
    let simulate::Campaign { document, truth } = simulated(&constants);
    let document = solved(document);
    for said in ["put the offset of sensor y", "put the constant of coil x"] {
        assert!(says(&document, said), "{:?}", axes(&document).findings);
    }
    assert_eq!(axes(&document).findings.len(), 2, "{:?}", axes(&document).findings);
    found(&axes(&document).offsets_nt, Axis::Y, 50.0);
    within(&document, &truth, 2.0);
}

#[test]
fn a_robust_fit_does_not_hide_whole_orientations() {
    let mut document = simulated(&plan()).document;
    swap(&mut document, 1, 4);
    let robust = Options { robust: true, ..Options::default() };
    let document = axescal::run(document, &robust).expect("five orientations suffice");
    let said = "of 168 readings were given no weight, in orientations 2, 5";
    assert!(says(&document, said), "{:?}", axes(&document).findings);
    // A few wild readings are left out and counted, and nothing is said of clean data.
    let simulate::Campaign { mut document, truth } = simulated(&plan());
    let clean = axescal::run(document.clone(), &robust).expect("directions");
    assert!(axes(&clean).findings.is_empty(), "{:?}", axes(&clean).findings);
    for (recording, row) in [(0, 1), (3, 4), (5, 2)] {
        document.recordings[recording].columns.get_mut("sensor_z_v").expect("a column")[row] += 0.5;
    }
    let document = axescal::run(document, &robust).expect("directions");
    let findings = &axes(&document).findings;
    assert!(findings[0].starts_with("3 of 168 readings were given no weight"), "{findings:?}");
    within(&document, &truth, 2.0);
}

#[test]
fn known_coils_are_never_the_result_of_the_same_readings() {
    let known = Options { known_coils: true, ..Options::default() };
    let document = solved(simulated(&plan()).document);
    let error = axescal::run(document.clone(), &known).expect_err("counted twice").to_string();
    assert!(error.contains("found from these same recordings"), "{error}");
    // What was given as known outlives a run that does not use it.
    let mut given = document;
    let axes_before = given.calibration.as_mut().and_then(|c| c.axes.as_mut()).expect("axes");
    axes_before.known_coils = axes_before.coils.clone();
    let once = axescal::run(given.clone(), &known).expect("directions");
    let plain = solved(once.clone());
    let again = axescal::run(plain, &known).expect("directions");
    assert_eq!(axes(&again), axes(&once));
}

#[test]
fn a_weak_coil_keeps_its_field_and_is_said() {
    let mut plan = plan();
    let drives = [[5e4, 0.0, 0.0], [-5e4, 0.0, 0.0], [0.0, 5e4, 0.0], [0.0, -5e4, 0.0], [0.0, 0.0, 45.0]];
    procedure(&mut plan).drives = drives.map(simulate::Drive::Vector).to_vec();
    let document = solved(simulated(&plan).document);
    let found = axes(&document);
    assert!(says(&document, "coil z produces at most 45 nT"), "{:?}", found.findings);
    let z = found.residual_field_nt.as_ref().and_then(|field| field.z.as_ref()).expect("a field");
    // 45 nT along a coil some 4° off its nominal axis leave at most 3 nT.
    assert!(z.value().abs() < 3.0, "{z:?}");
}
