//! Coverage: each 95 % interval holds the truth in 95 % of simulated campaigns.
//!
//! The proof is `FLUXCAL_CAMPAIGNS=5000 cargo test --release -p axescal --test it coverage:: -- --nocapture`.

use axescal::Options;
use common::{AxesCalibration, AxesDirections, Axis, Calibration, Quantity};
use nalgebra::{Matrix3, Vector3};
use physics::frames::{ARCSEC, matrix, small_rotation};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeMap;

use crate::build::{self, axes, procedure, simulated};

/// How often each interval held the truth.
#[derive(Default)]
struct Tally(BTreeMap<String, (usize, usize)>);

impl Tally {
    fn add(&mut self, name: String, inside: bool) {
        let entry = self.0.entry(name).or_default();
        entry.0 += usize::from(inside);
        entry.1 += 1;
    }

    fn quantity(&mut self, name: String, found: &Quantity, truth: f64, factor: f64) {
        let half = factor * found.std().expect("an uncertainty");
        self.add(name, (found.value() - truth).abs() <= half);
    }

    /// Prints all, and fails where a share is outside what chance allows.
    fn judge(&self, title: &str) {
        let percent = |inside: usize, tried: usize| 100.0 * inside as f64 / tried as f64;
        let mut outside = Vec::new();
        let (mut all_inside, mut all_tried) = (0, 0);
        for (name, &(inside, tried)) in &self.0 {
            println!("{title}: {name:<40} {:.1} % of {tried}", percent(inside, tried));
            if !testkit::agrees(inside, tried, [0.93, 0.97], self.0.len()) {
                outside.push(name);
            }
            (all_inside, all_tried) = (all_inside + inside, all_tried + tried);
        }
        assert!(outside.is_empty(), "{title}: {outside:?}");
        let all = percent(all_inside, all_tried);
        assert!((all - 95.0).abs() < 2.0, "{title}: all together {all} %");
    }
}

/// Directions within about half a degree of nominal, constants and offsets off by their uncertainty.
pub fn draw(plan: &simulate::Plan, campaign: usize) -> simulate::Plan {
    let mut generator = ChaCha8Rng::seed_from_u64(0x0C0FFEE ^ campaign as u64);
    let mut normal = move || -> f64 { StandardNormal.sample(&mut generator) };
    let mut plan = plan.clone();
    plan.seed = campaign as u64;
    let mut truth = plan.calibration.clone().expect("constants");
    let mut vary = |quantity: &mut Option<Quantity>| {
        if let Some(known) = quantity {
            *known = Quantity::Bare(known.value() + normal() * known.std().unwrap_or(0.0));
        }
    };
    for axis in Axis::ALL {
        if let Some(coil) = truth.coils.as_mut().and_then(|coils| coils.entry(axis).as_mut()) {
            vary(&mut coil.constant_nt_per_a);
            // Beside a stated residual field, the coils' offsets are part of what nulling leaves.
            if plan.facility.as_ref().is_some_and(|facility| facility.residual_field_std_nt.is_some()) {
                vary(&mut coil.offset_nt);
            }
        }
        if let Some(sensor) = truth.sensors.as_mut().and_then(|sensors| sensors.entry(axis).as_mut()) {
            vary(&mut sensor.sensitivity_nt_per_v);
            vary(&mut sensor.offset_nt);
        }
    }
    let tilted = |normal: &mut dyn FnMut() -> f64| {
        let columns = [0, 1, 2].map(|k| {
            let turn = Vector3::from_fn(|_, _| normal() * 0.01);
            small_rotation(&turn) * Vector3::ith(k, 1.0)
        });
        physics::frames::rows(&Matrix3::from_columns(&columns))
    };
    let part = |rows| Some(AxesDirections { matrix: Some(rows), ..AxesDirections::default() });
    truth.axes = Some(AxesCalibration {
        sensors: part(tilted(&mut normal)),
        coils: part(tilted(&mut normal)),
        ..Default::default()
    });
    plan.truth.calibration = Some(truth);
    if let Some(std) = plan.facility.as_ref().and_then(|facility| facility.residual_field_std_nt) {
        plan.truth.residual_field_nt =
            Some(Axis::ALL.into_iter().map(|axis| (axis, normal() * std)).collect());
    }
    plan
}

/// The directions of sensors and coils; the factor with which their intervals hold.
fn directions(tally: &mut Tally, axes: &AxesCalibration, truth: &simulate::Truth) -> f64 {
    let factor = axes.fit.as_ref().expect("a fit").coverage_factor_95;
    let truth = truth.calibration.axes.as_ref().expect("true axes");
    for (name, found, truth) in
        [("sensors", &axes.sensors, &truth.sensors), ("coils", &axes.coils, &truth.coils)]
    {
        let (found, columns) = (found.as_ref().expect("directions"), build::columns(truth));
        let (rows, covariance) = (found.matrix.expect("a matrix"), found.covariance.as_ref().expect("one"));
        for (i, j) in (0..9).filter(|k| k % 4 != 0).map(|k| (k / 3, k % 3)) {
            let cosine = Quantity::new(rows[i][j], covariance[3 * j + i][3 * j + i].sqrt());
            tally.quantity(format!("{name}[{i}][{j}]"), &cosine, columns[(i, j)], factor);
        }
        for (pair, [a, b]) in [("xy", [0, 1]), ("yz", [1, 2]), ("xz", [0, 2])] {
            let angle = columns.column(a).dot(&columns.column(b)).asin() / ARCSEC;
            let all = found.non_orthogonality_arcsec.as_ref().expect("angles");
            tally.quantity(format!("{name} off orthogonal {pair}"), &all[pair], angle, factor);
        }
    }
    factor
}

/// Whether the document declares the noise that the recordings have.
fn run(title: &str, plan: &simulate::Plan, options: &Options, declared: bool) {
    let mut tally = Tally::default();
    for campaign in 0..testkit::campaigns(30) as usize {
        let simulate::Campaign { document: mut stated, truth } = simulated(&draw(plan, campaign));
        if !declared {
            stated.instrument.as_mut().expect("an instrument").noise = None;
        }
        let document = axescal::run(stated.clone(), options).expect("directions");
        let axes = axes(&document);
        let factor = directions(&mut tally, axes, &truth);
        if !declared {
            assert_eq!(axes.fit.as_ref().expect("a fit").noise_source, "residuals");
            continue;
        }
        if let Some(field) = &axes.residual_field_nt {
            for (axis, value) in field.iter() {
                let true_field = truth.residual_field_nt[axis.index()];
                tally.quantity(format!("residual field {axis}"), value, true_field, factor);
            }
        }
        if let Some(offsets) = &axes.offsets_nt {
            let of = |calibration: &Calibration, axis: Axis| {
                let offset = calibration.sensor(axis).and_then(|sensor| sensor.offset_nt.as_ref());
                offset.map_or(0.0, Quantity::value)
            };
            let constants = stated.calibration.as_ref().expect("constants");
            for (axis, value) in offsets.iter() {
                let difference = of(&truth.calibration, axis) - of(constants, axis);
                tally.quantity(format!("offset {axis}"), value, difference, factor);
            }
        }
        for (number, orientation) in axes.orientations.iter().enumerate() {
            let Some(correction) = &orientation.correction_arcsec else { continue };
            let recording =
                stated.recordings.iter().find(|r| r.id == orientation.recordings[0]).expect("there");
            let given = physics::orientation(&stated, recording).expect("an orientation").rotation;
            let meant = truth.orientations.iter().find(|o| o.recording == recording.id).expect("there");
            let turn = matrix(&meant.orientation) * given.transpose();
            let turn = nalgebra::Rotation3::from_matrix_unchecked(turn).scaled_axis();
            for (axis, value) in correction.iter() {
                let name = format!("orientation {} about {axis}", number + 1);
                tally.quantity(name, value, turn[axis.index()] / ARCSEC, factor);
            }
        }
        if let Some(scales) = &axes.scales {
            let relative = |part: fn(&Calibration, Axis) -> Option<Quantity>, axis: Axis| {
                let of = |calibration: &Calibration| part(calibration, axis).expect("a constant").value();
                (of(&truth.calibration) / of(stated.calibration.as_ref().expect("constants"))).ln()
            };
            let sensor = |c: &Calibration, axis: Axis| c.sensor(axis)?.sensitivity_nt_per_v.clone();
            let coil = |c: &Calibration, axis: Axis| c.coil(axis)?.constant_nt_per_a.clone();
            // A reading is larger when the true sensitivity in nT/V is smaller.
            let logs =
                [Axis::ALL.map(|axis| -relative(sensor, axis)), Axis::ALL.map(|axis| relative(coil, axis))];
            for (kind, (found, logs)) in
                ["sensor", "coil"].iter().zip([&scales.sensors, &scales.coils].iter().zip(logs))
            {
                let mean = logs.iter().sum::<f64>() / 3.0;
                for (axis, scale) in found.iter() {
                    let (name, meant) = (format!("scale of {kind} {axis}"), logs[axis.index()] - mean);
                    tally.quantity(name, &Quantity::new(scale.value, scale.std), meant.exp(), factor);
                }
            }
        }
    }
    tally.judge(title);
}

fn plan() -> simulate::Plan {
    build::plan("magsat-axes")
}

fn robust() -> Options {
    Options { robust: true, ..Options::default() }
}

#[test]
fn noise_of_1_nt_and_theodolites_of_1_arcsec() {
    run("1 nT, 1\" theodolites read as angles", &plan(), &Options::default(), true);
    run("robust", &plan(), &robust(), true);
}

#[test]
fn noise_from_the_residuals() {
    let mut plan = plan();
    procedure(&mut plan).theodolite_angles = false;
    run("1 nT undeclared, 1\" theodolites as matrices", &plan, &Options::default(), false);
    run("robust, 1 nT undeclared", &plan, &robust(), false);
}

#[test]
fn free_scales() {
    let mut plan = plan();
    procedure(&mut plan).drives.truncate(7);
    run("free scales", &plan, &Options { free_scales: true, ..Options::default() }, true);
}

#[test]
fn drives_in_one_sense_with_stated_offsets() {
    let mut plan = plan();
    let one_sense =
        |drive: &simulate::Drive| matches!(drive, simulate::Drive::Named(name) if name.len() == 1);
    procedure(&mut plan).drives.retain(one_sense);
    // What nulling leaves is stated, and drawn anew in each campaign.
    plan.facility.as_mut().expect("a facility").residual_field_std_nt = Some(0.2);
    run("three drives in one sense", &plan, &Options::default(), true);
}
