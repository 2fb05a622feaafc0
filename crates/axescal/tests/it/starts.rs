//! Far starts, reversed wiring, swapped columns, a given first model, coils known beforehand.

use axescal::{Options, Start};
use common::{AxesCalibration, AxesDirections, Axis, Document, OneOrEach, Quantity};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use physics::frames::{ARCSEC, cube_rotations, matrix, rows};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::build::{self, axes, columns, matrices, off_arcsec, procedure, refused, solved};

fn plan() -> simulate::Plan {
    build::plan("magsat-axes")
}

fn directions(matrix: &Matrix3<f64>) -> Option<AxesDirections> {
    Some(AxesDirections { matrix: Some(rows(matrix)), ..AxesDirections::default() })
}

fn simulated(mut plan: simulate::Plan, mu: &Matrix3<f64>, eta: &Matrix3<f64>) -> Document {
    let truth = AxesCalibration { sensors: directions(mu), coils: directions(eta), ..Default::default() };
    plan.truth.calibration.get_or_insert_default().axes = Some(truth);
    build::simulated(&plan).document
}

/// Largest angle between found and true directions of the sensors, arcsec.
fn sensors_off(document: &Document, mu: &Matrix3<f64>) -> f64 {
    off_arcsec(&columns(&axes(document).sensors), mu)
}

/// Each axis turned by exactly `degrees` about an axis drawn across it.
fn tilted(generator: &mut ChaCha8Rng, degrees: f64) -> Matrix3<f64> {
    Matrix3::from_columns(&[0, 1, 2].map(|k| {
        let nominal = Vector3::ith(k, 1.0);
        let across = nominal.cross(&Vector3::from_fn(|_, _| generator.random_range(-1.0..1.0)));
        Rotation3::from_axis_angle(&Unit::new_normalize(across), degrees.to_radians()) * nominal
    }))
}

#[test]
fn thirty_degrees_from_nominal() {
    let mut generator = ChaCha8Rng::seed_from_u64(30);
    for case in 0..40 {
        let (mu, eta) = (tilted(&mut generator, 30.0), tilted(&mut generator, 5.0));
        let document = solved(simulated(plan(), &mu, &eta));
        let off = sensors_off(&document, &mu);
        assert!(off < 8.0, "case {case}: {off} arcsec");
        assert!(axes(&document).findings.is_empty(), "case {case}: {:?}", axes(&document).findings);
    }
}

#[test]
fn reversed_wiring_is_recognised() {
    let nominal = Matrix3::identity();
    for axis in Axis::ALL {
        let mut reversed = nominal;
        reversed.column_mut(axis.index()).neg_mut();
        let sensor = solved(simulated(plan(), &reversed, &nominal));
        assert!(sensors_off(&sensor, &reversed) < 8.0);
        assert_eq!(axes(&sensor).findings.len(), 1, "{:?}", axes(&sensor).findings);
        let coil = solved(simulated(plan(), &nominal, &reversed));
        for (document, said) in [
            (sensor, format!("sensor {axis} reads with the opposite sign")),
            (coil, format!("the field of coil {axis} has the opposite sign")),
        ] {
            let findings = &axes(&document).findings;
            assert!(findings[0].starts_with(&said), "{findings:?}");
        }
    }
}

#[test]
fn swapped_columns_are_recognised() {
    let mut document = simulated(plan(), &Matrix3::identity(), &Matrix3::identity());
    for recording in &mut document.recordings {
        let [x, y] = ["sensor_x_v", "sensor_y_v"].map(|name| recording.columns[name].clone());
        recording.columns.extend([("sensor_x_v".into(), y), ("sensor_y_v".into(), x)]);
    }
    let document = solved(document);
    let findings = &axes(&document).findings;
    assert!(findings[0].starts_with("sensor x reads along y"), "{findings:?}");
    assert!(findings[1].starts_with("sensor y reads along x"), "{findings:?}");
}

#[test]
fn a_first_model_from_the_document() {
    // So far from nominal that the identity is no start: the block is mounted turned by 75° about down.
    let [turn, first] = [75.0f64, 70.0]
        .map(|degrees| *Rotation3::from_axis_angle(&Vector3::z_axis(), degrees.to_radians()).matrix());
    let mut document = simulated(plan(), &turn, &Matrix3::identity());
    let model = AxesCalibration {
        sensors: directions(&first),
        coils: directions(&Matrix3::identity()),
        ..Default::default()
    };
    document.calibration.get_or_insert_default().axes = Some(model);
    let options = Options { start: Start::Document, ..Options::default() };
    let document = axescal::run(document, &options).expect("directions");
    assert!(sensors_off(&document, &turn) < 8.0);
    assert!(axes(&document).findings.is_empty(), "{:?}", axes(&document).findings);
}

/// SEN by another name turns every orientation, the start, and the sensors.
#[test]
fn turning_sen_turns_the_sensors_and_nothing_else() {
    let document = Document::parse(&testkit::read_fixture("nasa-1977/table-4.json")).expect("a document");
    let [mu, eta] = matrices(axes(&solved(document.clone())));
    for q in cube_rotations() {
        let mut turned = document.clone();
        for recording in &mut turned.recordings {
            let orientation = recording.conditions.orientation.as_mut().expect("an orientation");
            *orientation = rows(&(q * matrix(orientation)));
        }
        let coils = directions(&Matrix3::identity());
        turned.calibration.get_or_insert_default().axes =
            Some(AxesCalibration { sensors: directions(&q), coils, ..Default::default() });
        let options = Options { start: Start::Document, ..Options::default() };
        let [sensors, coils] = matrices(axes(&axescal::run(turned, &options).expect("directions")));
        assert!((sensors - q * mu).amax() < 1e-9 && (coils - eta).amax() < 1e-9, "{q}");
    }
}

/// One orientation only, three drives: enough when the coils are known (NASA eq. 33).
fn one_orientation(full_drives: bool) -> simulate::Plan {
    let mut plan = plan();
    procedure(&mut plan).orientations = simulate::Orientations::List(vec![rows(&Matrix3::identity())]);
    if full_drives {
        // B_c not diagonal.
        let drives = [[5e4, 2e4, -1e4], [1e4, 5e4, 2e4], [-2e4, 1e4, 5e4], [0.0; 3]];
        procedure(&mut plan).drives = drives.map(simulate::Drive::Vector).to_vec();
    }
    plan
}

#[test]
fn known_coils_need_one_orientation_and_any_drives() {
    let mut generator = ChaCha8Rng::seed_from_u64(2);
    for full_drives in [false, true] {
        let (mu, eta) = (tilted(&mut generator, 3.0), tilted(&mut generator, 2.0));
        let mut document = simulated(one_orientation(full_drives), &mu, &eta);
        let mut coils = directions(&eta).expect("directions");
        coils.std_arcsec = Some(OneOrEach::One(1.0));
        document.calibration.get_or_insert_default().axes =
            Some(AxesCalibration { coils: Some(coils.clone()), ..Default::default() });
        let unknown = refused(document.clone());
        assert!(unknown.contains("can turn together in 3 independent ways"), "{unknown}");
        let options = Options { known_coils: true, ..Options::default() };
        let document = axescal::run(document, &options).expect("directions");
        assert!(sensors_off(&document, &mu) < 15.0, "{}", sensors_off(&document, &mu));
        assert_eq!(axes(&document).known_coils, Some(coils), "what was given stands beside what came of it");
        // Run again, the given coils are used and not their own result.
        let again = axescal::run(document.clone(), &options).expect("directions");
        assert_eq!(axes(&again), axes(&document));
        // The theodolites' 1" and the coils' 1" are always there. On top comes the noise: at worst √2 nT,
        // against the smallest singular value of the drives.
        let sensors = axes(&document).sensors.as_ref().and_then(|part| part.std_arcsec.as_ref());
        let std = sensors.and_then(|std| std.get(Axis::X)).expect("an uncertainty");
        let smallest = if full_drives { smallest_drive() } else { 5e4 };
        let both = std::f64::consts::SQRT_2;
        let largest = both.hypot(both / smallest / ARCSEC);
        assert!(std > both && std < largest, "{std} where {both} to {largest} is expected");
    }
}

/// Smallest singular value of the three full drives, nT.
fn smallest_drive() -> f64 {
    let drives = Matrix3::new(5e4, 2e4, -1e4, 1e4, 5e4, 2e4, -2e4, 1e4, 5e4);
    let smallest: f64 = (drives * drives.transpose()).symmetric_eigenvalues().min();
    smallest.sqrt()
}

#[test]
fn noiseless_known_coils_equal_the_closed_form() {
    // (μᵀ)⁻¹ = R η b⁻¹ with b = B_m B_c⁻¹ (NASA eq. 33), evaluated apart from the fit.
    let mut plan = one_orientation(true);
    plan.instrument.as_mut().expect("an instrument").noise = None;
    plan.truth.residual_field_nt = None;
    plan.facility = None;
    let mut generator = ChaCha8Rng::seed_from_u64(3);
    let (mu, eta) = (tilted(&mut generator, 3.0), tilted(&mut generator, 2.0));
    let mut document = simulated(plan, &mu, &eta);
    let recording = &document.recordings[0];
    let calibration = document.calibration.as_ref().expect("constants");
    let value = |quantity: &Option<Quantity>| quantity.as_ref().expect("a constant").value();
    let drive = Matrix3::from_fn(|i, row| {
        let coil = calibration.coil(Axis::ALL[i]).expect("a coil");
        recording.columns[&format!("coil_{}_a", Axis::ALL[i])][row] * value(&coil.constant_nt_per_a)
    });
    let measured = Matrix3::from_fn(|i, row| {
        let sensor = calibration.sensor(Axis::ALL[i]).expect("a sensor");
        let volts = recording.columns[&format!("sensor_{}_v", Axis::ALL[i])][row];
        volts * value(&sensor.sensitivity_nt_per_v) + value(&sensor.offset_nt)
    });
    let b = measured * drive.try_inverse().expect("independent drives");
    let rotation = physics::orientation(&document, recording).expect("a rotation").rotation;
    let closed =
        (rotation * eta * b.try_inverse().expect("regular")).try_inverse().expect("regular").transpose();
    document.calibration.get_or_insert_default().axes =
        Some(AxesCalibration { coils: directions(&eta), ..Default::default() });
    let known = Options { known_coils: true, ..Options::default() };
    let document = axescal::run(document, &known).expect("directions");
    let found = build::columns(&axes(&document).sensors);
    assert!((found - closed).amax() < 1e-9, "{found} {closed}");
    assert!((found - mu).amax() < 1e-9);
}

#[test]
fn one_wrong_constant_is_named() {
    let free = Options { free_scales: true, ..Options::default() };
    let wrong = |change: fn(&mut common::Calibration)| {
        let mut plan = plan();
        let mut truth = plan.calibration.clone().expect("constants");
        change(&mut truth);
        plan.truth.calibration = Some(truth);
        let document = simulated(plan, &Matrix3::identity(), &Matrix3::identity());
        let document = axescal::run(document, &free).expect("directions");
        axes(&document).scales.as_ref().expect("scales").verdict.clone()
    };
    let verdict = wrong(|_| {});
    assert!(verdict.starts_with("the readings agree"), "{verdict}");
    let named = |verdict: &str, name: &str, ppm: f64| {
        let found = verdict.split(&format!("one constant explains it, {name} by ")).nth(1).expect(verdict);
        let numbers: Vec<f64> =
            found.split([' ', '±']).filter_map(|word| word.replace('−', "-").parse().ok()).collect();
        assert!((numbers[0] - ppm).abs() < 4.0 * numbers[1] && numbers[1] < 20.0, "{verdict}");
    };
    let verdict = wrong(|truth| {
        let coil = truth.coils.as_mut().and_then(|coils| coils.x.as_mut()).expect("coil x");
        coil.constant_nt_per_a = Some(Quantity::Bare(41234.5 * 1.0002));
    });
    named(&verdict, "coil x", 200.0);
    // A sensor of more nT for each volt reads less.
    let verdict = wrong(|truth| {
        let sensor = truth.sensors.as_mut().and_then(|sensors| sensors.z.as_mut()).expect("sensor z");
        sensor.sensitivity_nt_per_v = Some(Quantity::Bare(6402.6 * 1.001));
    });
    named(&verdict, "sensor z", -1000.0);
}
