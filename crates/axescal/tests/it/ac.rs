//! AC drive: amplitudes below one code of the converter are found with the dither of the other coils.

use physics::frames::matrix;

use crate::build::{self, axes, matrices, procedure, refused, says, simulated, solved, worst_arcsec};

/// With exact theodolites and no codes, unless a test says otherwise.
fn plan() -> simulate::Plan {
    let mut plan = build::plan("magsat-axes-ac");
    plan.facility = None;
    plan.instrument.as_mut().expect("an instrument").quantisation_v = None;
    plan
}

/// Cycles, samples a second and dither of the runs.
fn runs(plan: &mut simulate::Plan, cycles: f64, rate_hz: f64, dither_nt: Option<f64>) {
    let ac = procedure(plan).ac.as_mut().expect("an AC drive");
    (ac.cycles, ac.rate_hz) = (cycles, rate_hz);
    ac.dither_nt = dither_nt.unwrap_or(ac.dither_nt);
}

#[test]
fn signals_below_one_code_are_found_with_dither() {
    // 100 cycles at 0.1 Hz sampled at 100 Hz, codes of 1.92 nT, cross signals of 0.5 to 2 nT: twelve runs of
    // 100 000 rows. Exact theodolites, so that what is seen is what the sine fits lose.
    let mut plan = build::plan("magsat-axes-ac");
    plan.facility = None;
    let with_dither = simulated(&plan);
    assert_eq!(with_dither.document.recordings[0].rows(), 100_000);
    let dithered = worst_arcsec(&solved(with_dither.document), &with_dither.truth);
    assert!(dithered < 0.5, "{dithered} arcsec with dither");
}

#[test]
fn the_delay_of_a_channel_is_reported_as_a_phase_and_does_no_harm() {
    let mut plan = plan();
    runs(&mut plan, 20.0, 20.0, None);
    let simulate::Campaign { mut document, truth } = simulated(&plan);
    // Sensor y answers 10 ms late: its readings are those of an earlier time. Of a sine that is a phase.
    for recording in &mut document.recordings {
        let column = recording.columns.get_mut("sensor_y_v").expect("a column");
        let phase = std::f64::consts::TAU * 0.1 * 0.010;
        let quarter = 2.5 * 20.0;
        let n = column.len();
        let ahead: Vec<f64> = (0..n).map(|row| column[(row + n - quarter as usize) % n]).collect();
        *column =
            column.iter().zip(ahead).map(|(now, before)| now * phase.cos() + before * phase.sin()).collect();
    }
    let document = solved(document);
    let phases = axes(&document).phases.iter();
    let delays: Vec<(f64, f64)> = phases.map(|phase| (phase.delay_s, phase.p_value)).collect();
    assert!((delays[1].0 - 0.010).abs() < 1e-5 && delays[1].1 < 1e-6, "{delays:?}");
    assert!(delays[0].0.abs() < 1e-5 && delays[0].1 > 1e-4, "{delays:?}");
    let findings = &axes(&document).findings;
    let said = findings.iter().find(|finding| finding.contains("sensor y responds")).expect("said");
    assert!(said.contains("equivalent to a delay of 10 ms"), "{findings:?}");
    assert!(worst_arcsec(&document, &truth) < 1.0);
}

#[test]
fn coils_out_of_phase_are_taken_as_they_are() {
    let mut plan = plan();
    runs(&mut plan, 20.0, 20.0, Some(0.0));
    procedure(&mut plan).drives =
        [[5e4, 2e4, 0.0], [0.0, 5e4, 2e4], [2e4, 0.0, 5e4]].map(simulate::Drive::Vector).to_vec();
    let simulate::Campaign { mut document, truth } = simulated(&plan);
    // The second coil of each run is set 0.5 rad behind; the readings are made again.
    let true_axes = truth.calibration.axes.as_ref().expect("true axes");
    let [mu, eta] = matrices(true_axes).map(|mut matrix| {
        for mut column in matrix.column_iter_mut() {
            column.normalize_mut();
        }
        matrix
    });
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
    let document = solved(document);
    assert!(worst_arcsec(&document, &truth) < 1e-3, "{}", worst_arcsec(&document, &truth));
    assert!(!says(&document, "answers"), "{:?}", axes(&document).findings);
}

#[test]
fn a_channel_that_never_leaves_its_code_asks_for_dither() {
    let mut plan = build::plan("magsat-axes-ac");
    runs(&mut plan, 10.0, 10.0, Some(0.0));
    plan.instrument.as_mut().expect("an instrument").noise = None;
    // Cross signals of about half a nT below codes of 1.92 nT.
    plan.truth.calibration = None;
    let error = refused(simulated(&plan).document);
    let said = ["stay within one quantisation step of the converter", "dither"];
    assert!(said.iter().all(|said| error.contains(said)), "{error}");
}

#[test]
fn runs_that_are_too_short_or_too_few_are_refused_in_words() {
    let mut plan = plan();
    runs(&mut plan, 0.6, 100.0, Some(0.0));
    let error = refused(simulated(&plan).document);
    assert!(error.contains("found 0.599 cycles of 0.1 Hz"), "{error}");

    runs(&mut plan, 3.0, 100.0, Some(0.0));
    procedure(&mut plan).drives.truncate(2);
    let mut document = simulated(&plan).document;
    for recording in &mut document.recordings {
        let time = recording.columns["time_s"].clone();
        let late = time.iter().map(|t| 0.5 * (std::f64::consts::TAU * 0.1 * t - 1.0).sin());
        recording.columns.insert("coil_z_a".into(), late.collect());
    }
    let error = refused(document);
    assert!(error.contains("coils out of phase in fewer than three independent runs"), "{error}");
}
