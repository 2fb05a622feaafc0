//! AC drive: amplitudes below one code of the converter are found with the dither of the other coils.

use axescal::Options;
use common::Document;
use nalgebra::Matrix3;
use physics::frames::{ARCSEC, angle, matrix};

fn plan() -> simulate::Plan {
    simulate::Plan::parse(&testkit::read_fixture("plans/magsat-axes-ac.json")).expect("a plan")
}

/// Largest angle between the found and the true directions of sensors and coils, arcsec.
fn worst_arcsec(document: &Document, truth: &simulate::Truth) -> f64 {
    let found = document.calibration.as_ref().and_then(|c| c.axes.as_ref()).expect("axes");
    let meant = truth.calibration.axes.as_ref().expect("true axes");
    let pair = |part: fn(&common::AxesCalibration) -> Option<&common::AxesDirections>| -> (Matrix3<f64>, Matrix3<f64>) {
        let of = |axes| matrix(&part(axes).and_then(|directions| directions.matrix).expect("a matrix"));
        (of(found), of(meant))
    };
    [pair(|axes| axes.sensors.as_ref()), pair(|axes| axes.coils.as_ref())]
        .iter()
        .flat_map(|(found, meant)| {
            (0..3).map(|k| angle(&found.column(k).into_owned(), &meant.column(k).into_owned()) / ARCSEC)
        })
        .fold(0.0, f64::max)
}

#[test]
fn signals_below_one_code_are_found_with_dither() {
    // 100 cycles at 0.1 Hz sampled at 100 Hz, codes of 1.92 nT, cross signals of 0.5 to 2 nT: twelve runs of
    // 100 000 rows. Exact theodolites, so that what is seen is what the sine fits lose.
    let mut plan = plan();
    plan.facility = None;
    let with_dither = simulate::campaign(&plan).expect("simulated");
    assert_eq!(with_dither.document.recordings[0].rows(), 100_000);
    let document = axescal::run(with_dither.document, &Options::default()).expect("directions");
    let dithered = worst_arcsec(&document, &with_dither.truth);
    assert!(dithered < 0.5, "{dithered} arcsec with dither");
}

#[test]
fn the_delay_of_a_channel_is_reported_as_a_phase_and_does_no_harm() {
    let mut plan = plan();
    plan.facility = None;
    if let simulate::Procedure::AxesOrientation(axes) = &mut plan.procedures[0] {
        let ac = axes.ac.as_mut().expect("an AC drive");
        (ac.cycles, ac.rate_hz) = (20.0, 20.0);
    }
    let instrument = plan.instrument.as_mut().expect("an instrument");
    instrument.quantisation_v = None;
    let simulate::Campaign { mut document, truth } = simulate::campaign(&plan).expect("simulated");
    // Sensor y answers 10 ms late: its readings are those of an earlier time. A pure sine lets that be made
    // by its phase.
    for recording in &mut document.recordings {
        let column = recording.columns.get_mut("sensor_y_v").expect("a column");
        let phase = std::f64::consts::TAU * 0.1 * 0.010;
        let quarter = 2.5 * 20.0;
        let n = column.len();
        let ahead: Vec<f64> = (0..n).map(|row| column[(row + n - quarter as usize) % n]).collect();
        *column =
            column.iter().zip(ahead).map(|(now, before)| now * phase.cos() + before * phase.sin()).collect();
    }
    let document = axescal::run(document, &Options::default()).expect("directions");
    let axes = document.calibration.as_ref().and_then(|c| c.axes.as_ref()).expect("axes");
    let delays: Vec<(f64, f64)> = axes.phases.iter().map(|phase| (phase.delay_s, phase.p_value)).collect();
    assert!((delays[1].0 - 0.010).abs() < 1e-5 && delays[1].1 < 1e-6, "{delays:?}");
    assert!(delays[0].0.abs() < 1e-5 && delays[0].1 > 1e-4, "{delays:?}");
    assert!(
        axes.findings.iter().any(|finding| finding.contains("sensor y responds")
            && finding.contains("equivalent to a delay of 10 ms")),
        "{:?}",
        axes.findings
    );
    assert!(worst_arcsec(&document, &truth) < 1.0);
}

#[test]
fn coils_out_of_phase_are_taken_as_they_are() {
    let mut plan = plan();
    plan.facility = None;
    let instrument = plan.instrument.as_mut().expect("an instrument");
    instrument.quantisation_v = None;
    if let simulate::Procedure::AxesOrientation(axes) = &mut plan.procedures[0] {
        let ac = axes.ac.as_mut().expect("an AC drive");
        (ac.cycles, ac.rate_hz, ac.dither_nt) = (20.0, 20.0, 0.0);
        axes.drives =
            [[5e4, 2e4, 0.0], [0.0, 5e4, 2e4], [2e4, 0.0, 5e4]].map(simulate::Drive::Vector).to_vec();
    }
    let simulate::Campaign { mut document, truth } = simulate::campaign(&plan).expect("simulated");
    // The second coil of each run is set 0.5 rad behind; the readings are made again by the same linear
    // chain.
    let (mu, eta) = {
        let axes = truth.calibration.axes.as_ref().expect("true axes");
        let of = |part: &Option<common::AxesDirections>| {
            let mut matrix = matrix(&part.as_ref().and_then(|part| part.matrix).expect("a matrix"));
            matrix.column_iter_mut().for_each(|mut column| {
                column.normalize_mut();
            });
            matrix
        };
        (of(&axes.sensors), of(&axes.coils))
    };
    for recording in &mut document.recordings {
        let rotation = matrix(&recording.conditions.orientation.expect("an orientation"));
        let time = recording.columns["time_s"].clone();
        let smaller = ["x", "y", "z"].map(|axis| {
            let column = &recording.columns[&format!("coil_{axis}_a")];
            let largest = column.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            (largest > 0.1 && largest < 1.0, largest)
        });
        for (k, axis) in ["x", "y", "z"].iter().enumerate().filter(|(k, _)| smaller[*k].0) {
            let late = |t: &f64| smaller[k].1 * (std::f64::consts::TAU * 0.1 * t - 0.5).sin();
            recording.columns.insert(format!("coil_{axis}_a"), time.iter().map(late).collect());
        }
        let coil = |axis: &str, row: usize| recording.columns[&format!("coil_{axis}_a")][row] * 40000.0;
        let readings: Vec<nalgebra::Vector3<f64>> = (0..time.len())
            .map(|row| {
                mu.transpose()
                    * rotation
                    * eta
                    * nalgebra::Vector3::new(coil("x", row), coil("y", row), coil("z", row))
            })
            .collect();
        for (k, axis) in ["x", "y", "z"].iter().enumerate() {
            let values = readings.iter().map(|reading| reading[k] / 6400.0);
            recording.columns.insert(format!("sensor_{axis}_v"), values.collect());
        }
    }
    let document = axescal::run(document, &Options::default()).unwrap_or_else(|error| panic!("{error}"));
    assert!(worst_arcsec(&document, &truth) < 1e-3, "{}", worst_arcsec(&document, &truth));
    let axes = document.calibration.as_ref().and_then(|c| c.axes.as_ref()).expect("axes");
    assert!(axes.findings.iter().all(|finding| !finding.contains("answers")), "{:?}", axes.findings);
}

#[test]
fn a_channel_that_never_leaves_its_code_asks_for_dither() {
    let mut plan = plan();
    if let simulate::Procedure::AxesOrientation(axes) = &mut plan.procedures[0] {
        let ac = axes.ac.as_mut().expect("an AC drive");
        (ac.cycles, ac.rate_hz, ac.dither_nt) = (10.0, 10.0, 0.0);
    }
    plan.instrument.as_mut().expect("an instrument").noise = None;
    // Cross signals of about half a nT below codes of 1.92 nT.
    plan.truth.calibration = None;
    let document = simulate::campaign(&plan).expect("simulated").document;
    let error = axescal::run(document, &Options::default()).expect_err("hidden").to_string();
    assert!(
        error.contains("stay within one quantisation step of the converter") && error.contains("dither"),
        "{error}"
    );
}

#[test]
fn runs_that_are_too_short_or_too_few_are_refused_in_words() {
    let mut plan = plan();
    plan.instrument.as_mut().expect("an instrument").quantisation_v = None;
    if let simulate::Procedure::AxesOrientation(axes) = &mut plan.procedures[0] {
        let ac = axes.ac.as_mut().expect("an AC drive");
        (ac.cycles, ac.rate_hz, ac.dither_nt) = (0.6, 100.0, 0.0);
    }
    let document = simulate::campaign(&plan).expect("simulated").document;
    let error = axescal::run(document, &Options::default()).expect_err("too short").to_string();
    assert!(error.contains("found 0.599 cycles of 0.1 Hz"), "{error}");

    if let simulate::Procedure::AxesOrientation(axes) = &mut plan.procedures[0] {
        axes.ac.as_mut().expect("an AC drive").cycles = 3.0;
        axes.drives.truncate(2);
    }
    let mut document = simulate::campaign(&plan).expect("simulated").document;
    for recording in &mut document.recordings {
        let time = recording.columns["time_s"].clone();
        let late = time.iter().map(|t| 0.5 * (std::f64::consts::TAU * 0.1 * t - 1.0).sin());
        recording.columns.insert("coil_z_a".into(), late.collect());
    }
    let error = axescal::run(document, &Options::default()).expect_err("out of phase").to_string();
    assert!(error.contains("coils out of phase in fewer than three independent runs"), "{error}");
}
